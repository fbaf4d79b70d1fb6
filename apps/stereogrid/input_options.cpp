// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <filesystem>
#include <string>

#include "cli/program.hpp"
#include "frame_stages.hpp"
#include "input.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/rectifier.hpp"

namespace stereogrid::app {

const char* const frame_range_help{
    "Only these frames: places in the input from 0, both ends included; either may be left out (5:9, :99, 100:)."};

void add_input_options(Command command, InputOptions& options) {
  command.group(Group::input);
  command
      .add_option(
          "INPUT [RIGHT]", options.paths,
          "A drive's folder, a bag of ROS 2 (.mcap, .db3, or their folder), LEFT and RIGHT image, video or folder of "
          "images, a video of both, or a built-in scene.")
      .required()
      .expected(1, 2);
  command.add_option(
      "--calibration FILE", options.calibration,
      "Calibration file instead of the input's own: calibration.yaml, or one of KITTI, ROS, OpenCV, Kalibr, "
      "EuRoC, ORB-SLAM, Basalt, DepthAI, ZED, MATLAB, VINS-Fusion, Middlebury and others.");
  command.add_option("--cameras A,B,...", options.cameras,
                     "Several stereo pairs of one vehicle, which make one grid: folders in INPUT, or namespaces of a "
                     "bag or of ROS 2. Default: the list in calibration.yaml, else one pair.");
  command.add_option("--poses none|file|odometry|FILE", options.poses,
                     "Source of poses. 'file': the input's own pose file; 'odometry': visual odometry; "
                     "'none': a static vehicle; or another pose file. Default: file if there is one, else "
                     "odometry.");
  command.add_option("--mask FILE.png", options.mask,
                     "Mask of the left image's size: pixels of the vehicle itself, such as the bonnet, are "
                     "black (0) and not used. Replaces the calibration's mask.");
  command.group(Group::other_input);
  command.add_option("--disparities DIR", options.disparities,
                     "Disparity images instead of right images: PNG (KITTI), PFM, TIFF, NPY or NPZ, named as the left "
                     "images.");
  command.add_flag("--with-right", options.with_right,
                   "With --disparities: track features in the right images, too. Default: in the left images and the "
                   "disparities.");
  command.add_option("--depth DIR", options.depth,
                     "Depth images instead of right images: PNG or TIFF of 16 bits, PFM, TIFF, NPY or NPZ of floats in "
                     "metres, named as the left images and aligned to them.");
  command
      .add_option("--depth-scale UNITS", options.depth_scale,
                  "Units of 16-bit depth images in a metre: 1000 (millimetres), 5000 (TUM), 256 (KITTI). Default: 5000 "
                  "beside TUM's rgb.txt and depth.txt, else 1000.")
      .check(number(0.001, 1e6));
  command.add_option("--labels DIR", options.labels,
                     "Label images of a semantic segmentation, named as the left images; the calibration's 'labels' "
                     "says which values are to be ignored, passable, obstacles or movers. Default: labels/ beside the "
                     "images.");
  command
      .add_option("--layout", options.layout,
                  "Position of the left and right image in images or a video of both. Default: from the calibration "
                  "or the aspect.")
      .one_of({"side-by-side", "top-bottom"});
  command.add_option("--left-topic TOPIC", options.left_topic,
                     "Topic of the left images, for a bag or ROS 2. Default: by name.");
  command.add_option("--right-topic TOPIC", options.right_topic,
                     "Topic of the right images, or of depth or disparities, for a bag or ROS 2.");
  command.add_option("--grid-topic TOPIC", options.grid_topic,
                     "Topic of grids of another source, for --fuse grids. Default: the only one, or the only one whose "
                     "name has 'occupancy'.");
  command
      .add_option("--pair-tolerance-ms MS", options.pair_tolerance_ms,
                  "Maximum stamp difference of a pair, for a bag or two cameras.")
      .check(number(0, 1000))
      .show_default();
}

void add_fuse_option(Command command, std::string& fuse) {
  constexpr auto sources{names_of(FusedSource{})};
  command
      .add_option("--fuse", fuse,
                  "Fuse the stereo grid with that of another source (fusion.*): the input's lidar sweeps, the grids of "
                  "a bag or of topics (nav_msgs/OccupancyGrid, GridCells), or its label images.")
      .one_of({sources.begin(), sources.end()})
      .show_default();
}

namespace {

void log_mask(const io::MaskUse& use) {
  if (!use.text.empty()) spdlog::log(use.is_odd ? spdlog::level::warn : spdlog::level::info, "{}", use.text);
}

}  // namespace

void log_input(const Input& input) {
  const Rig& rig{input.source->rig()};
  const std::string kind{input.recording != nullptr ? input.recording->contents().kind : "built-in scene"};
  spdlog::info("{}: {} frames of {} × {} px", kind, input.source->size(), rig.width_px, rig.height_px);
  if (input.recording == nullptr) return log_mask(input.mask_use);
  for (const std::string& note : input.recording->contents().notes) spdlog::info("{}", note);
  for (const std::string& warning : input.recording->contents().warnings) spdlog::warn("{}", warning);
}

Image<std::uint8_t> mask_of(const std::string& given, const io::Calibration& calibration) {
  const std::filesystem::path file{given.empty() ? calibration.mask : std::filesystem::path{given}};
  if (file.empty()) return {};
  Image<std::uint8_t> mask{io::read_mask(file, calibration)};
  log_mask(io::use_of_mask(file, mask));
  return mask;
}

void log_calibration(const io::Calibration& calibration) {
  if (calibration.is_upside_down) {
    throw ConfigError{"'rotate' in the calibration is of recordings. Turn the images in the cameras or their driver."};
  }
  for (const std::string& note : calibration.notes) spdlog::info("{}", note);
  if (!calibration.has_extrinsics) {
    spdlog::info("extrinsics: not in the calibration");
  }
  if (calibration.is_lens_unnamed) {
    spdlog::warn(
        "lens: four distortion coefficients without a lens model, taken as k1 k2 p1 p2. Of cv::fisheye, name the file "
        "in "
        "a calibration.yaml with 'from: FILE' and 'lens: fisheye'.");
  }
  for (const std::string& oddity : oddities(calibration.rig)) spdlog::warn("{}", oddity);
  for (const std::string& warning : calibration.warnings) spdlog::warn("{}", warning);
}

}  // namespace stereogrid::app
