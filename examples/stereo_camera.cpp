// SPDX-License-Identifier: Apache-2.0
//
// A camera that delivers both images side by side, as most USB stereo cameras do, up to the costmap of a planner:
// capture, rectification, visual odometry, occupancy grid, 8-bit values.
//
// stereo_camera SOURCE CALIBRATION [FRAMES]     SOURCE: a camera's number, or a film; CALIBRATION: as in docs/input.md
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <opencv2/videoio.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/odometry.hpp"
#include "stereogrid/opencv.hpp"
#include "stereogrid/pipeline.hpp"

namespace {

using namespace stereogrid;

/// Splits each image of a camera into left and right half.
class SideBySideCamera {
 public:
  explicit SideBySideCamera(const std::string& source) {
    const bool is_number{source.find_first_not_of("0123456789") == std::string::npos};
    is_number ? capture_.open(std::atoi(source.c_str())) : capture_.open(source);
    if (!capture_.isOpened()) throw std::runtime_error{source + ": cannot be opened as a camera or a film"};
    is_film_ = !is_number;
  }

  [[nodiscard]] int width_px() const { return static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)) / 2; }
  [[nodiscard]] int height_px() const { return static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT)); }

  /// False: the film is at its end, or the camera is gone. The frame's memory is used again.
  bool next(StereoFrame& frame) {
    if (!capture_.read(both_)) return false;
    frame.index = frames_++;
    frame.name = std::to_string(frame.index);
    frame.stamp_ns = stamp_ns();
    const int width{both_.cols / 2};
    assign(frame.left, view_of(both_.colRange(0, width)));
    assign(frame.right, view_of(both_.colRange(width, 2 * width)));
    return true;
  }

 private:
  // Stamp of the frame: time of the call for a camera, of the file for a video.
  std::int64_t stamp_ns() {
    if (is_film_) return static_cast<std::int64_t>(1e9 * static_cast<double>(frames_) / capture_.get(cv::CAP_PROP_FPS));
    return std::chrono::nanoseconds{std::chrono::system_clock::now().time_since_epoch()}.count();
  }

  cv::VideoCapture capture_;
  cv::Mat both_;
  bool is_film_{false};
  std::int64_t frames_{0};
};

/// The rig after rectification, where that is needed, and how it is mounted.
Rig rig_of(const io::Calibration& calibration, const std::optional<io::Rectifier>& rectifier) {
  if (!rectifier) return calibration.rig;
  Rig rig{rectifier->rig()};
  rig.camera_height_m = calibration.rig.camera_height_m;
  rig.camera_pitch_rad = calibration.rig.camera_pitch_rad;
  rig.camera_roll_rad = calibration.rig.camera_roll_rad;
  return rig;
}

void print(const StereoFrame& frame, const FrameResult& result) {
  const std::vector<std::int8_t> costmap{occupancy_values(result.vehicle.occupancy.view(), OccupancyScale::nav2)};
  std::size_t occupied{0};
  std::size_t unknown{0};
  for (const std::int8_t value : costmap) {
    occupied += value == 100 ? 1U : 0U;
    unknown += value == -1 ? 1U : 0U;
  }
  std::printf("frame %s: %zu cells occupied, %zu unknown of %zu; %zu obstacles; %.0f ms\n", frame.name.c_str(),
              occupied, unknown, costmap.size(), result.obstacles.size(), result.timing_ms.total);
  for (const Warning& warning : result.warnings) std::printf("  %s\n", warning.text.c_str());
}

void run(const std::string& source, const std::string& calibration_file, int frames) {
  SideBySideCamera camera{source};
  const io::Calibration calibration{io::read_calibration(calibration_file, camera.width_px(), camera.height_px())};
  std::optional<io::Rectifier> rectifier;
  if (calibration.raw) rectifier.emplace(*calibration.raw, camera.width_px(), camera.height_px());
  const Rig rig{rig_of(calibration, rectifier)};
  VisualOdometry odometry{rig};
  Pipeline pipeline{preset("default"), rig, {.stages = false}};
  StereoFrame frame;
  for (int i{0}; i < frames && camera.next(frame); ++i) {
    if (rectifier) {
      frame.left = rectifier->left(frame.left);
      frame.right = rectifier->right(frame.right);
    }
    frame.world_from_vehicle = odometry.update(frame).world_from_vehicle;
    print(frame, pipeline.process(frame));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: stereo_camera SOURCE CALIBRATION [FRAMES]\n");
    return 64;
  }
  try {
    run(argv[1], argv[2], argc > 3 ? std::atoi(argv[3]) : 1'000'000);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stereo_camera: %s\n", error.what());
    return 65;
  }
  return 0;
}
