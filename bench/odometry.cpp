// SPDX-License-Identifier: Apache-2.0
//
// Drift and time of the visual odometry: bench_odometry INPUT..., each a recording with poses or a scene:NAME, against
// its poses; on one thread of OpenCV.
#include <opencv2/core/utility.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/odometry.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr std::string_view scene_prefix{"scene:"};

std::unique_ptr<FrameSource> open(const std::string& input) {
  if (!input.starts_with(scene_prefix)) return io::open_recording({{input}, {}, {}});
  return std::make_unique<scenes::Scene>(scenes::parse_scene(input.substr(scene_prefix.size())));
}

Pose2 between(const Pose2& from, const Pose2& to) {
  const double c{std::cos(from.yaw_rad)};
  const double s{std::sin(from.yaw_rad)};
  const double x_m{to.x_m - from.x_m};
  const double y_m{to.y_m - from.y_m};
  return {c * x_m + s * y_m, c * y_m - s * x_m, to.yaw_rad - from.yaw_rad};
}

struct Error {
  double way_m;
  double yaw_deg;
};

Error error_of(const Pose2& found, const Pose2& expected) {
  const double yaw_rad{std::remainder(found.yaw_rad - expected.yaw_rad, 2 * std::numbers::pi)};
  return {std::hypot(found.x_m - expected.x_m, found.y_m - expected.y_m), std::abs(yaw_rad) * 180 / std::numbers::pi};
}

void print(const std::string& input) {
  const std::unique_ptr<FrameSource> source{open(input)};
  VisualOdometry odometry{source->rig(), {}};
  std::vector<Pose2> found;
  std::vector<Pose2> poses;
  std::chrono::duration<double, std::milli> taken{0};
  for (std::size_t i{0}; i < source->size(); ++i) {
    const StereoFrame frame{source->load(i)};
    if (!frame.world_from_vehicle) throw InputError{input, "has no poses.", "Give a drive that has some."};
    poses.push_back(*frame.world_from_vehicle);
    const auto start = std::chrono::steady_clock::now();
    found.push_back(odometry.update(frame).world_from_vehicle);
    taken += std::chrono::steady_clock::now() - start;
  }
  if (poses.size() < 2) throw InputError{input, "has fewer than two frames.", "Give a drive."};
  double way_m{0};
  Error steps{0, 0};
  for (std::size_t i{1}; i < poses.size(); ++i) {
    const Pose2 expected{between(poses[i - 1], poses[i])};
    const Error step{error_of(between(found[i - 1], found[i]), expected)};
    way_m += std::hypot(expected.x_m, expected.y_m);
    steps = {steps.way_m + step.way_m, steps.yaw_deg + step.yaw_deg};
  }
  if (way_m == 0) throw InputError{input, "stands still.", "Give a drive that moves."};
  const Error end{error_of(between(found.front(), found.back()), between(poses.front(), poses.back()))};
  const auto frames = static_cast<double>(poses.size());
  const std::string name{input.starts_with(scene_prefix) ? input : std::filesystem::path{input}.filename().string()};
  std::printf("| %s | %.0f | %.1f | %.2f | %.4f | %.1f | %.3f | %.1f |\n", name.c_str(), frames, way_m,
              100 * end.way_m / way_m, end.yaw_deg / way_m, 1e3 * steps.way_m / (frames - 1),
              steps.yaw_deg / (frames - 1), taken.count() / frames);
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::printf("| input | frames | way, m | error at the end, %% | error at the end, °/m | error of a step, mm | ° | ");
  std::printf("ms a frame |\n|---|---|---|---|---|---|---|---|\n");
  try {
    for (int i{1}; i < argc; ++i) print(argv[i]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_odometry: %s\n", error.what());
    return 65;
  }
  return 0;
}
