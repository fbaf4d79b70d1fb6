// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "commands.hpp"
#include "config_options.hpp"
#include "input.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t frames_looked_at{50};

struct Options {
  InputOptions input;
  ConfigOptions config;
  bool all_frames{false};
};

void print_row(const char* what, const std::string& text) {
  fmt::print("{:<13}{}\n", what, text);
}

std::string text_or(const std::filesystem::path& path, const char* otherwise) {
  return path.empty() ? otherwise : io::printable_path(path);
}

void print_camera(const Rig& rig) {
  constexpr double degrees{57.29577951308232};
  print_row("size", fmt::format("{} × {} px", rig.width_px, rig.height_px));
  print_row("camera", fmt::format("focal length {:.6g} px, centre ({:.6g}, {:.6g}) px, baseline {:.4g} m", rig.focal_px,
                                  rig.centre_u_px, rig.centre_v_px, rig.baseline_m));
  print_row("mounting",
            fmt::format("{:.3g} m above the road, looks down by {:.2f}°, rolled by {:.2f}°", rig.camera_height_m,
                        rig.camera_pitch_rad * degrees, rig.camera_roll_rad * degrees));
}

void print_recording(const io::Recording& recording) {
  const io::RecordingContents& contents{recording.contents()};
  print_row("stereo", recording.gives_disparities() ? fmt::format("left images with given disparities ({})",
                                                                  io::printable_path(contents.disparities))
                                                    : "left and right images");
  print_row("calibration",
            fmt::format("{} ({}){}", text_or(contents.calibration_file, "none"), contents.calibration.kind,
                        contents.calibration.raw ? ", raw images: rectified on loading" : ""));
  print_row("poses",
            text_or(contents.poses_file, contents.wants_odometry ? "none: visual odometry from the images"
                                                                 : "none: the vehicle is taken to stand still"));
  print_row("lidar", recording.has_scans() ? "yes" : "no");
  print_row("truth", text_or(contents.truth_folder, "no"));
  if (contents.sample_bits > 8) print_row("samples", fmt::format("{} bits in 16", contents.sample_bits));
}

void print_stamps(const Input& input) {
  if (input.source->size() < 2) return;
  const double rate{rate_hz(input)};
  print_row("rate", fmt::format("{:.4g} frames per second, {:.1f} s in all", rate,
                                static_cast<double>(input.source->size() - 1) / rate));
}

/// What a run with these parameters would do.
void print_plan(const Config& asked, const Rig& rig) {
  const Pipeline pipeline{asked, rig};
  const Config& config{pipeline.config()};
  const GridGeometry grid{pipeline.vehicle_grid()};
  const double depth_of_one_px{rig.focal_px * rig.baseline_m};
  const int last{config.matching.disparities - 1};
  const double far_m{config.grid.length_m};
  print_row("grid", fmt::format("{:g} m ahead × {:g} m wide, {} × {} cells of {:g} m", config.grid.length_m,
                                config.grid.width_m, grid.nx, grid.ny, grid.cell_size_m));
  print_row("disparities",
            fmt::format("1 to {} px: {:.1f} m to {:.0f} m; one pixel is {:.2f} m at {:g} m", last,
                        depth_of_one_px / last, depth_of_one_px, far_m * far_m / depth_of_one_px, far_m));
}

std::vector<std::size_t> frames_to_look_at(std::size_t frames, bool all) {
  std::set<std::size_t> indices;
  const std::size_t count{all ? frames : std::min(frames, frames_looked_at)};
  for (std::size_t i{0}; i < count; ++i) indices.insert(count == 1 ? 0 : i * (frames - 1) / (count - 1));
  return {indices.begin(), indices.end()};
}

struct Verdict {
  std::vector<std::string> complaints;
  std::size_t looked_at{0};
  std::size_t usable{0};
  bool swapped{false};
};

Verdict look_at_frames(const FrameSource& source, bool all) {
  Verdict verdict;
  for (const std::size_t index : frames_to_look_at(source.size(), all)) {
    ++verdict.looked_at;
    try {
      const StereoFrame frame{source.load(index)};
      if (verdict.usable++ > 0) continue;
      if (const auto complaint{io::complaint_if_swapped(frame)}) {
        verdict.swapped = true;
        verdict.complaints.push_back(*complaint);
      }
    } catch (const InputError& error) {
      verdict.complaints.push_back(fmt::format("frame {} cannot be used: {}", source.name(index), error.what()));
    }
  }
  return verdict;
}

int show(const Options& options) {
  const Config config{config_from(options.config)};
  const Input input{open_input(options.input)};
  const Rig& rig{input.source->rig()};
  const std::size_t frames{input.source->size()};
  print_row("input", fmt::format("{} ({})", fmt::join(options.input.paths, " "),
                                 input.recording != nullptr ? input.recording->contents().kind : "built-in scene"));
  print_row("frames", frames == 0
                          ? "none"
                          : fmt::format("{}, {} to {}", frames, input.source->name(0), input.source->name(frames - 1)));
  print_camera(rig);
  if (input.recording != nullptr) print_recording(*input.recording);
  print_stamps(input);
  print_plan(config, rig);
  Verdict verdict{look_at_frames(*input.source, options.all_frames)};
  print_row("looked at", fmt::format("{} of {} frames, {} can be used", verdict.looked_at, frames, verdict.usable));
  if (input.recording != nullptr) {
    const auto& warnings{input.recording->contents().warnings};
    verdict.complaints.insert(verdict.complaints.begin(), warnings.begin(), warnings.end());
  }
  for (const std::string& complaint : verdict.complaints) print_row("complaint", complaint);
  const bool usable{verdict.usable > 0 && !verdict.swapped};
  print_row("verdict", !usable ? "cannot be used" : verdict.complaints.empty() ? "fine" : "usable");
  return usable ? exit_done : exit_input;
}

}  // namespace

void add_info_command(CLI::App& tool, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{tool.add_subcommand("info", "What is in an input, what would be used, what is wrong with it.")};
  add_input_options(*command, options->input);
  add_config_options(*command, options->config);
  command->add_flag("--all-frames", options->all_frames,
                    fmt::format("Load every frame, not {} spread over the drive.", frames_looked_at));
  command->callback([options, &exit_code] { exit_code = show(*options); });
}

}  // namespace stereogrid::app
