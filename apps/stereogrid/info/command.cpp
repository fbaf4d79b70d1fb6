// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/config_options.hpp"
#include "cli/console.hpp"
#include "cli/program.hpp"
#include "diagnostics/frame_tally.hpp"
#include "diagnostics/own_vehicle.hpp"
#include "frame_stages.hpp"
#include "info/look.hpp"
#include "input.hpp"
#include "preset_choice.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

constexpr double degrees{57.29577951308232};

constexpr std::size_t frames_looked_at{50};

struct InfoOptions {
  InputOptions input;
  ConfigOptions config;
  std::string proposed_mask;
};

void print_row(const char* what, const std::string& text) {
  print("{:<13}{}\n", what, text);
}

std::string text_or(const std::filesystem::path& path, const char* otherwise) {
  return path.empty() ? otherwise : io::printable_path(path);
}

void print_camera(const Rig& rig, bool has_extrinsics, bool estimates) {
  print_row("size", fmt::format("{} × {} px", rig.width_px, rig.height_px));
  print_row("camera", fmt::format("focal length {:.6g} px, centre ({:.6g}, {:.6g}) px, baseline {:.4g} m", rig.focal_px,
                                  rig.cx_px, rig.cy_px, rig.baseline_m));
  const std::string used{fmt::format("{:.3g} m above the road, pitch {:.2f}°, roll {:.2f}°", rig.camera_height_m,
                                     rig.camera_pitch_rad * degrees, rig.camera_roll_rad * degrees)};
  print_row("extrinsics", has_extrinsics ? used
                          : estimates    ? "none in the calibration: estimated from the images"
                                         : used + " (assumed: not in the calibration, and ground.estimate is off)");
}

/// True: only their places differ.
bool is_like(Rig rig, const Rig& other) {
  rig.camera_x_m = other.camera_x_m;
  rig.camera_y_m = other.camera_y_m;
  rig.camera_yaw_rad = other.camera_yaw_rad;
  return rig == other;
}

/// Text of one of several cameras.
std::string of_camera(const std::string& name, const std::string& text) {
  return name.empty() ? text : fmt::format("{}: {}", name, text);
}

/// Place of a camera that is not at the vehicle's origin, or one of several.
void print_place(const std::string& name, const Rig& rig) {
  if (camera_place(rig) == Pose2{} && name.empty()) return;
  print_row("place", of_camera(name, fmt::format("{:.3g} m ahead, {:.3g} m to the left, turned by {:.1f}°",
                                                 rig.camera_x_m, rig.camera_y_m, rig.camera_yaw_rad * degrees)));
}

std::string poses_text(const io::RecordingContents& contents) {
  const std::string& source{contents.poses_source};
  if (!contents.poses_file.empty()) return source.empty() ? io::printable_path(contents.poses_file) : source;
  return fmt::format(
      "none: {}{}", contents.wants_odometry ? "visual odometry from the images" : "the vehicle is taken to stand still",
      source.empty() ? "" : fmt::format(" ({})", source));
}

void print_mask(const io::RecordingContents& contents) {
  if (contents.mask_file.empty()) return;
  print_row("mask", of_camera(contents.camera_name, io::printable_path(contents.mask_file)));
}

void print_recording(const io::Recording& recording) {
  const io::RecordingContents& contents{recording.contents()};
  print_row("stereo", recording.gives_disparities()
                          ? fmt::format("left images with external disparities ({})", contents.external)
                          : "left and right images");
  const std::string& kind{contents.calibration.kind};
  print_row("calibration", (contents.calibration_file.empty()
                                ? kind
                                : fmt::format("{} ({})", io::printable_path(contents.calibration_file), kind)) +
                               (contents.calibration.raw ? ", raw images: rectified on loading" : ""));
  for (const std::string& note : contents.calibration.notes) print_row("", note);
  print_mask(contents);
  for (const auto& other : recording.other_cameras()) print_mask(other->contents());
  print_row("poses", poses_text(contents));
  print_row("lidar", recording.has_scans() ? "yes" : "no");
  if (!contents.labels.empty()) print_row("labels", io::printable_path(contents.labels));
  if (!contents.grids_source.empty()) print_row("grids", contents.grids_source);
  print_row("truth", text_or(contents.truth_folder, "no"));
  for (const std::string& note : contents.notes) {
    if (note.starts_with("stamps: ")) print_row("stamps", note.substr(8));
  }
  if (contents.sample_bits > 8) print_row("samples", fmt::format("{} bits in 16", contents.sample_bits));
}

void print_stamps(const Input& input) {
  if (input.source->size() < 2) return;
  const double rate{rate_hz(input)};
  print_row("rate", fmt::format("{:.4g} frames per second, {:.1f} s in all", rate,
                                static_cast<double>(input.source->size() - 1) / rate));
}

/// Prints the smallest steps up and down that the camera resolves, by range (docs/terrain.md, formulas 1, 4 and 6).
void print_terrain(const Config& config, const Rig& rig, const std::string& camera) {
  constexpr double sigma_px{0.3};
  constexpr double drops{3};  // in smallest drops that geometry allows
  if (config.ground.model != GroundModel::terrain) return;
  const double focal_baseline{rig.focal_px * rig.baseline_m};
  const double slope{std::tan(config.vehicle.slope_max_deg / degrees)};
  std::string text;
  for (const double share : {0.1, 0.2, 0.3, 0.4}) {
    const double x{share * config.grid.length_m};
    const double range_sigma{x * x * sigma_px / focal_baseline};
    const double up{
        std::max({config.vehicle.step_max_m, 2 * rig.camera_height_m / x * range_sigma, 2 * slope * range_sigma})};
    const double down{std::max(config.vehicle.step_max_m, drops * rig.camera_height_m * x / (focal_baseline - x))};
    text += fmt::format("{}{:.2f}/{:.2f} m at {:.2g} m", text.empty() ? "" : ", ", up, down, x);
  }
  print_row("steps", of_camera(camera, "up/down, visible from " + text));
}

/// `looks`: with the extrinsics that were found.
void print_plan(const Config& asked, const std::vector<Look>& looks, bool extrinsics_given) {
  std::vector<Rig> rigs;
  for (const Look& look : looks) rigs.push_back(look.rig);
  const Pipeline pipeline{asked, rigs, {.extrinsics_given = extrinsics_given}};
  const Config& config{pipeline.config()};
  const GridGeometry grid{pipeline.vehicle_grid()};
  const int last{config.matching.disparities - 1};
  const double far_m{config.grid.length_m};
  print_row("grid", fmt::format("{:g} m ahead{} × {:g} m wide, {} × {} cells of {:g} m", far_m,
                                config.grid.rear_m > 0 ? fmt::format(" and {:g} m behind", config.grid.rear_m) : "",
                                config.grid.width_m, grid.nx, grid.ny, grid.cell_size_m));
  for (std::size_t i{0}; i < looks.size(); ++i) {
    const Look& look{looks[i]};
    if (i > 0 && is_like(look.rig, looks[i - 1].rig)) continue;
    const double depth_of_one_px{look.rig.focal_px * look.rig.baseline_m};
    print_row("disparities",
              of_camera(look.camera,
                        fmt::format("1 to {} px: {:.1f} m to {:.0f} m; one pixel is {:.2f} m at {:g} m", last,
                                    depth_of_one_px / last, depth_of_one_px, far_m * far_m / depth_of_one_px, far_m)));
    print_terrain(config, look.rig, look.camera);
  }
  print_row("memory", fmt::format("{:.0f} MB", static_cast<double>(pipeline.memory_use().host_bytes) / 1e6));
}

/// In degrees; never −0.0.
double tenths(double angle_rad) {
  return std::round(angle_rad * degrees * 10) / 10 + 0.0;
}

void print_look(const Look& look, std::size_t frames, const Config& config) {
  const auto row = [&look](const char* what, const std::string& text) {
    print_row(what, of_camera(look.camera, text));
  };
  row("looked at", fmt::format("{} of {} frames, {} can be used", look.looked_at, frames, look.usable));
  if (look.row_residual_px) {
    row("rows",
        fmt::format("matched corners of both images differ by {:.2f} rows (median; well-calibrated pairs: below 0.3)",
                    *look.row_residual_px));
  }
  if (!config.ground.estimate || look.tried == 0) return;
  const std::string found{fmt::format("found in {} of {} frames", look.road_found, look.tried)};
  row("road", look.road_found == 0
                  ? found
                  : fmt::format("{}: camera {:.2f} ± {:.3f} m above it, pitch {:.1f} ± {:.1f}°, roll {:.1f} ± {:.1f}°",
                                found, look.road.height_m, look.road.height_sigma_m, tenths(look.road.pitch_rad),
                                tenths(look.road.pitch_sigma_rad), tenths(look.road.roll_rad),
                                tenths(look.road.roll_sigma_rad)));
  if (!look.mount.empty()) row("estimated", look.mount + " (for calibration.yaml)");
}

/// Takes the whole drive through the pipeline.
Image<std::uint8_t> look_for_own_vehicle(const Input& input, const Config& config, OwnVehicle& search) {
  Pipeline pipeline{config, input.source->rig(), {.mask = input.mask, .extrinsics_given = input.extrinsics_given}};
  PoseStage poses{input.poses, input.source->rig(), input.mask};
  Image<std::uint8_t> picture;
  Progress progress{"frames", input.source->size()};
  for (std::size_t i{0}; i < input.source->size(); ++i) {
    progress.update(i);
    try {
      StereoFrame frame{input.source->load(i)};
      poses.place(frame);
      search.add(frame, pipeline.process(frame));
      picture = std::move(frame.left);
    } catch (const InputError&) {  // said where the frames are looked at
    }
  }
  return picture;
}

/// Writes a mask that is black at the vehicle and shows the last frame elsewhere, for inspection.
void propose_mask(const Input& input, const Config& config, const std::string& file) {
  if (input.recording != nullptr && input.recording->contents().calibration.raw) {
    throw ConfigError{
        "--propose-mask needs rectified images: of a raw pair, a mask is of the images before they are "
        "rectified. Draw it on one of them."};
  }
  OwnVehicle search{input.source->rig()};
  const Image<std::uint8_t> picture{look_for_own_vehicle(input, config, search)};
  const std::string seen{fmt::format("in {} frames over {:.0f} m", search.frames(), search.travelled_m())};
  if (!search.is_sure()) {
    return print_row("own vehicle", "nothing can be said: the vehicle was seen to move " + seen +
                                        ", and 20 frames over 20 m are needed (with poses, and a road that is known)");
  }
  Image<std::uint8_t> mask{search.mask(config.matching.window_px / 2 + 2)};
  if (mask.empty()) return print_row("own vehicle", "not in view " + seen + "; no mask is written");
  std::size_t masked{0};
  for (std::size_t i{0}; i < mask.size(); ++i) {
    const bool is_used{mask.data()[i] != 0 && (input.mask.empty() || input.mask.data()[i] != 0)};
    mask.data()[i] = is_used ? static_cast<std::uint8_t>(64 + picture.data()[i] * 3 / 4) : 0;
    masked += is_used ? 0 : 1;
  }
  io::write_png(file, mask);
  print_row(
      "own vehicle",
      fmt::format("in {:.1f} % of the image, the same {}. The mask is written to {}: look at it, then give it with "
                  "--mask, or as mask: FILE in calibration.yaml",
                  100.0 * static_cast<double>(masked) / static_cast<double>(mask.size()), seen, file));
}

int show(InfoOptions& options) {
  static_cast<void>(config_from(options.config));  // rejects options before the input is opened
  const Input input{open_input(options.input)};
  const PresetChoice choice{choose_preset(input)};
  const bool is_automatic{options.config.preset == automatic_preset};
  if (is_automatic) options.config.preset = choice.preset;
  const Config config{config_from(options.config)};
  const std::size_t frames{input.source->size()};
  print_row("input", fmt::format("{} ({})", fmt::join(options.input.paths, " "),
                                 input.recording != nullptr ? input.recording->contents().kind : "built-in scene"));
  print_row("frames", frames == 0
                          ? "none"
                          : fmt::format("{}, {} to {}", frames, input.source->name(0), input.source->name(frames - 1)));
  const std::vector<std::string> names{names_of_cameras(*input.source)};
  for (std::size_t i{0}; i < names.size(); ++i) {
    const Rig& rig{input.source->rigs()[i]};
    print_place(names[i], rig);
    if (i > 0 && is_like(rig, input.source->rigs()[i - 1])) continue;
    const io::Recording* const recording{
        i == 0 || input.recording == nullptr ? input.recording : input.recording->other_cameras()[i - 1].get()};
    print_camera(rig, recording == nullptr || recording->contents().calibration.has_extrinsics, config.ground.estimate);
  }
  if (input.recording != nullptr) print_recording(*input.recording);
  print_stamps(input);
  if (is_automatic) print_row("preset", fmt::format("{}: {}", choice.preset, choice.reason));
  if (const std::string advice{advice_on_preset(config, choice.rig)}; !advice.empty()) print_row("preset", advice);
  const Looks looked{look_at_frames(input, config, frames_looked_at)};
  const std::vector<Look>& looks{looked.cameras};
  print_plan(config, looks, input.extrinsics_given);
  std::vector<std::string> problems;
  if (input.recording != nullptr) problems = input.recording->contents().warnings;
  problems.insert(problems.end(), looked.problems.begin(), looked.problems.end());
  for (const Look& look : looks) {
    print_look(look, frames, config);
    for (const std::string& problem : look.problems) problems.push_back(of_camera(look.camera, problem));
    if (look.is_hopeless && looks.size() > 1) problems.push_back(of_camera(look.camera, "cannot be used"));
  }
  if (const auto text{contradiction_of_poses(input)}) problems.push_back(*text);
  if (!options.proposed_mask.empty()) propose_mask(input, config, options.proposed_mask);
  for (const std::string& problem : problems) print_row("problem", problem);
  const bool is_hopeless{std::ranges::all_of(looks, &Look::is_hopeless)};
  print_row("verdict", is_hopeless ? "cannot be used" : problems.empty() ? "fine" : "usable");
  return is_hopeless ? exit_input : exit_done;
}

}  // namespace

void add_info_command(Command tool, int& exit_code) {
  auto options{std::make_shared<InfoOptions>()};
  const Command command{
      tool.add_command("info", "Contents and faults of an input, and the files that a run would use.")};
  add_input_options(command, options->input);
  add_config_options(command, options->config);
  command.group(Group::output);
  command.add_option(
      "--propose-mask FILE.png", options->proposed_mask,
      "Go through the whole drive, look for what shows the vehicle itself at the lower edge of the image, "
      "and write a mask for --mask. Masked pixels are black; the rest shows the image for inspection.");
  command.callback([options, &exit_code] { exit_code = show(*options); });
}

}  // namespace stereogrid::app
