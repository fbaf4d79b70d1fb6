// SPDX-License-Identifier: Apache-2.0
#include "input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>

#include "device_options.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/rosbag/rosbag.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

bool is_scene(const std::string& path) {
  return path.starts_with("scene:");
}

PoseSource source_of(const std::string& poses) {
  return poses == "none" ? PoseSource::none : poses == "odometry" ? PoseSource::odometry : PoseSource::input;
}

Input open_scene(const InputOptions& options) {
  const PoseSource poses{source_of(options.poses)};
  const bool has_pose_file{poses == PoseSource::input && !options.poses.empty() && options.poses != "file"};
  if (options.paths.size() > 1 || !options.calibration.empty() || has_pose_file || !options.disparities.empty() ||
      options.with_right || !options.depth.empty() || !options.layout.empty() || !options.cameras.empty()) {
    throw ConfigError{"A built-in scene brings its own cameras, images, calibration and poses: give it alone."};
  }
  auto scene{std::make_unique<scenes::Scene>(scenes::parse_scene(options.paths.front()))};
  Input input;
  if (!options.mask.empty()) {
    input.mask = io::read_mask(options.mask, scene->rig().width_px, scene->rig().height_px);
    input.mask_use = io::use_of_mask(options.mask, input.mask);
  }
  input.scene = scene.get();
  input.extrinsics_given = true;
  input.poses = poses;
  input.source = std::move(scene);
  return input;
}

std::optional<std::size_t> parse_index(std::string_view text) {
  std::size_t index{0};
  const auto [end, error]{std::from_chars(text.data(), text.data() + text.size(), index)};
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return index;
}

std::string text_of(const fs::path& path) {
  return path.empty() ? std::string{} : io::printable_path(fs::weakly_canonical(path));
}

}  // namespace

Input open_input(const InputOptions& options) {
  const bool is_of_bag{!is_scene(options.paths.front()) && options.paths.size() == 1 &&
                       rosbag::is_bag(options.paths.front())};
  if (!is_of_bag && (!options.left_topic.empty() || !options.right_topic.empty() || !options.grid_topic.empty())) {
    throw ConfigError{
        "--left-topic, --right-topic and --grid-topic choose among the topics of a bag, but the input is none."};
  }
  if (is_scene(options.paths.front())) return open_scene(options);
  io::InputArguments arguments;
  arguments.paths.assign(options.paths.begin(), options.paths.end());
  if (!options.calibration.empty()) arguments.calibration = options.calibration;
  arguments.poses = options.poses;
  if (!options.disparities.empty()) arguments.disparities = options.disparities;
  arguments.with_right = options.with_right;
  if (!options.depth.empty()) arguments.depth = options.depth;
  if (options.depth_scale > 0) arguments.depth_units_per_m = options.depth_scale;
  if (!options.mask.empty()) arguments.mask = options.mask;
  if (!options.labels.empty()) arguments.labels = options.labels;
  arguments.cameras = options.cameras;
  if (!options.layout.empty()) {
    arguments.layout = options.layout == "side-by-side" ? io::ImageLayout::side_by_side : io::ImageLayout::top_bottom;
  }
  auto recording{is_of_bag ? rosbag::open_recording(
                                 arguments, {{options.left_topic, options.right_topic, rosbag::SecondTopic::right},
                                             options.pair_tolerance_ms,
                                             options.grid_topic})
                           : io::open_recording(arguments)};
  Input input;
  input.recording = recording.get();
  input.mask = recording->contents().mask;
  input.extrinsics_given = recording->contents().calibration.has_extrinsics;
  for (const auto& camera : recording->other_cameras()) {
    input.extrinsics_given = input.extrinsics_given && camera->contents().calibration.has_extrinsics;
    input.other_masks.push_back(camera->contents().mask);
  }
  input.poses = recording->has_poses()                 ? PoseSource::input
                : recording->contents().wants_odometry ? PoseSource::odometry
                                                       : PoseSource::none;
  input.source = std::move(recording);
  return input;
}

std::vector<std::string> names_of_cameras(const FrameSource& source) {
  std::vector<std::string> names{source.camera_names()};
  if (source.rigs().size() == 1) return {""};
  for (std::size_t i{names.size()}; i < source.rigs().size(); ++i) names.push_back(fmt::format("camera{}", i));
  return names;
}

/// Cameras of a recording, so that the same ones make the same run: folders relative to INPUT, whether they are options
/// or of calibration.yaml, or namespaces of a bag.
std::vector<std::string> cameras_of(const io::Recording& recording, const InputOptions& options) {
  const fs::path root{fs::path{options.paths.front()} / ""};
  const auto name_of = [base = root.lexically_normal()](const io::Recording& one) {
    return one.contents().root.lexically_normal().lexically_relative(base).generic_string();
  };
  std::vector<std::string> names{name_of(recording)};
  if (names.front() == "." || names.front().empty()) return options.cameras;
  for (const auto& other : recording.other_cameras()) names.push_back(name_of(*other));
  return names;
}

io::RunInput describe(const Input& input, const InputOptions& options) {
  if (input.scene != nullptr) return {"scene", options.paths, options.poses, "", "", text_of(options.mask)};
  std::vector<std::string> paths;
  for (const std::string& path : options.paths) paths.push_back(text_of(path));
  if (input.recording == nullptr) return {"arrays", {"arrays"}, options.poses, "", ""};
  const io::RecordingContents& contents{input.recording->contents()};
  const bool has_odometry{input.poses == PoseSource::odometry};
  if (!options.cameras.empty() || !input.recording->other_cameras().empty()) {  // each camera's folder has its files
    return {contents.kind,
            std::move(paths),
            has_odometry ? "odometry" : options.poses,
            "",
            "",
            "",
            cameras_of(*input.recording, options)};
  }
  return {contents.kind,
          std::move(paths),
          has_odometry ? "odometry" : text_of(contents.poses_file),
          text_of(contents.calibration_file),
          text_of(contents.disparities),
          text_of(contents.mask_file)};
}

double rate_hz(const Input& input) {
  if (input.scene != nullptr) return input.scene->options().rate_hz;
  if (input.recording == nullptr) return 10;
  const std::vector<io::RecordedFrame>& frames{input.recording->contents().frames};
  std::vector<double> steps_s;
  for (std::size_t i{1}; i < frames.size(); ++i) {
    const double step_s{static_cast<double>(frames[i].stamp_ns - frames[i - 1].stamp_ns) * 1e-9};
    if (step_s > 0) steps_s.push_back(step_s);
  }
  if (steps_s.empty()) return 10;
  const auto middle{steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2)};
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  return 1 / *middle;
}

io::FrameRange parse_frame_range(const std::string& text, std::size_t frames) {
  if (frames == 0) throw InputError{"The input has no frames."};
  if (text.empty()) return {0, frames};
  const std::size_t colon{text.find(':')};
  const std::string first_text{text.substr(0, colon)};
  const std::string last_text{colon == std::string::npos ? first_text : text.substr(colon + 1)};
  const std::optional<std::size_t> first{first_text.empty() ? 0 : parse_index(first_text)};
  const std::optional<std::size_t> last{last_text.empty() ? std::numeric_limits<std::size_t>::max()
                                                          : parse_index(last_text)};
  if (!first || !last || *last < *first) {
    throw ConfigError{fmt::format("--frames {}: give FIRST:LAST, such as 0:99 for the first hundred frames.", text)};
  }
  if (*first >= frames) {
    throw ConfigError{fmt::format("--frames {}: the input has {} frames, 0 to {}.", text, frames, frames - 1)};
  }
  return {*first, std::min(*last, frames - 1) + 1};
}

std::string without_digits(std::string text) {
  const auto is_digit = [](char letter) { return letter >= '0' && letter <= '9'; };
  std::string rest;
  bool is_in_name{false};
  for (const char letter : text) {
    if (!is_digit(letter)) is_in_name = letter == '_' || std::isalpha(static_cast<unsigned char>(letter)) != 0;
    if (is_in_name || !is_digit(letter)) rest += letter;
  }
  return rest;
}

StereoFrame first_usable_frame(const FrameSource& source, io::FrameRange range) {
  std::string first_error;
  for (std::size_t index{range.first}; index < range.end; ++index) {
    try {
      return source.load(index);
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  throw InputError{
      fmt::format("None of the {} frames can be used. The first one: {}", range.end - range.first, first_error)};
}

io::RunDescription describe_run(const Input& input, const InputOptions& options, const Pipeline& pipeline,
                                io::FrameRange frames) {
  const bool given{input.recording != nullptr && input.recording->gives_disparities()};
  io::RunDescription run;
  run.config = pipeline.config();
  run.input = describe(input, options);
  run.matcher = given ? "given" : "own";
  run.device = std::string{name_of(pipeline.back_end())};
  run.rig = pipeline.rig();
  run.other_rigs.assign(pipeline.rigs().begin() + 1, pipeline.rigs().end());
  run.camera_names = pipeline.camera_names();
  run.grid = pipeline.vehicle_grid();
  run.world_grid = pipeline.world_grid();
  run.simd_target = std::string{simd_target()};
  run.threads = pipeline.threads();
  run.frames = frames;
  return run;
}

}  // namespace stereogrid::app
