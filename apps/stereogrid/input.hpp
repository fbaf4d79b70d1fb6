// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/run_folder/description.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::io {
struct Calibration;
struct PlacedGrid;
class Recording;
}  // namespace stereogrid::io
namespace stereogrid::scenes {
class Scene;
}

namespace stereogrid::app {

class Command;

/// INPUT on the command line, and what the user says about it.
struct InputOptions {
  std::vector<std::string> paths;  ///< a folder, a bag, LEFT and RIGHT, or one "scene:…"
  std::string calibration{};
  std::string poses{};  ///< "", "file", "none", "odometry" or a file's name
  std::string disparities{};
  std::string depth{};
  double depth_scale{0};  ///< 0: found
  std::string mask{};
  std::string layout{};  ///< images that show both cameras: "", "side-by-side", "top-bottom"
  // topics of a bag
  std::string left_topic{};
  std::string right_topic{};
  double pair_tolerance_ms{10};
  std::string grid_topic{};
  std::string labels{};
  bool with_right{false};              ///< beside `disparities`
  std::vector<std::string> cameras{};  ///< folders or namespaces of several stereo pairs
};

void add_input_options(Command command, InputOptions& options);
/// --fuse, with the names of FusedSource.
void add_fuse_option(Command command, std::string& fuse);

/// Source of the poses.
enum class PoseSource { input, none, odometry };

/// An opened INPUT. One of `recording` and `scene` is set and points into `source`; neither: frames in memory.
struct Input {
  std::unique_ptr<FrameSource> source;
  const io::Recording* recording{nullptr};
  const scenes::Scene* scene{nullptr};
  PoseSource poses{PoseSource::input};
  Image<std::uint8_t> mask{};                      ///< PipelineOptions::mask
  io::MaskUse mask_use{};                          ///< effect of a scene's mask; recordings name theirs
  std::vector<Image<std::uint8_t>> other_masks{};  ///< PipelineOptions::other_masks
  bool extrinsics_given{false};                    ///< PipelineOptions::extrinsics_given
  /// Grid of another source at the time of a live frame, in the vehicle frame. None: only recordings have grids.
  std::function<std::optional<io::PlacedGrid>(const StereoFrame&)> grid_at{};
};

/// Throws InputError, ConfigError.
[[nodiscard]] Input open_input(const InputOptions& options);

/// Names of the cameras of a source; "": there is one.
[[nodiscard]] std::vector<std::string> names_of_cameras(const FrameSource& source);

/// For run.json.
[[nodiscard]] io::RunInput describe(const Input& input, const InputOptions& options);

/// Logs the choices made for the input, and its anomalies.
void log_input(const Input& input);

/// The same of a calibration that no recording brings.
void log_calibration(const io::Calibration& calibration);

/// Mask of such a calibration, or of the file `given`; logs what it leaves out. Empty: there is none. Throws
/// InputError.
[[nodiscard]] Image<std::uint8_t> mask_of(const std::string& given, const io::Calibration& calibration);

/// Frames per second, from the stamps.
[[nodiscard]] double rate_hz(const Input& input);

/// Reads "FIRST:LAST", both inclusive, from 0, either may be left out; "" is all. Throws ConfigError, and
/// InputError where there are no frames.
[[nodiscard]] io::FrameRange parse_frame_range(const std::string& text, std::size_t frames);

/// The first frame that can be loaded. Throws InputError where there is none.
[[nodiscard]] StereoFrame first_usable_frame(const FrameSource& source, io::FrameRange range);

extern const char* const frame_range_help;

/// A text without its numbers: warnings that differ only in them are one and the same. Digits of names stay, such as
/// those of cameras.
[[nodiscard]] std::string without_digits(std::string text);

/// Description of a run of `pipeline` over frames of an input; the caller sets preset and outputs.
[[nodiscard]] io::RunDescription describe_run(const Input& input, const InputOptions& options, const Pipeline& pipeline,
                                              io::FrameRange frames);

}  // namespace stereogrid::app
