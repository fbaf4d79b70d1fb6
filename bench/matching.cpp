// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Times our matchers and OpenCV's on the same pairs in one run and prints the ratios. Ours match two hypotheses
// (upright and road), OpenCV's one; all with sub-pixel, uniqueness and left-right test as each has them by default.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "backend/cpu.hpp"
#include "matching/matching.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr int repetitions{11};

double median_ms(const std::function<void()>& work) {
  std::vector<double> times;
  work();
  for (int i{0}; i < repetitions; ++i) {
    const auto start{std::chrono::steady_clock::now()};
    work();
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(times.begin(), times.begin() + repetitions / 2, times.end());
  return times[repetitions / 2];
}

double time_ours(const StereoFrame& frame, const Rig& rig, MatchingMethod method, int window_px, int disparities,
                 int threads) {
  MatchingConfig config;
  config.method = method;
  config.window_px = window_px;
  config.disparities = disparities;
  config.speckle_px = 0;  // OpenCV's default
  Cpu cpu{threads};
  MatchingSpace space{rig.width_px, rig.height_px, config, threads};
  Matches matches{rig.width_px, rig.height_px};
  const RoadPlane plane{road_plane(rig, {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad})};
  return median_ms([&] { match(cpu, frame.left.view(), frame.right.view(), plane, config, space, matches); });
}

cv::Mat mat_of(const Image<std::uint8_t>& image) {
  return cv::Mat{image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())};
}

void compare(const char* scene_text, int disparities, int threads) {
  const scenes::Scene scene{scenes::parse_scene(scene_text)};
  const StereoFrame frame{scene.load(10)};
  cv::setNumThreads(threads);
  cv::Mat disparity;
  const auto block{cv::StereoBM::create(disparities, 21)};
  const auto semi_global{
      cv::StereoSGBM::create(0, disparities, 5, 200, 800, 1, 0, 10, 100, 2, cv::StereoSGBM::MODE_SGBM_3WAY)};
  const double block_ms{median_ms([&] { block->compute(mat_of(frame.left), mat_of(frame.right), disparity); })};
  const double three_way_ms{
      median_ms([&] { semi_global->compute(mat_of(frame.left), mat_of(frame.right), disparity); })};
  const double ours_ms{time_ours(frame, scene.rig(), MatchingMethod::correlation, 21, disparities, threads)};
  const double ours_semi_global_ms{
      time_ours(frame, scene.rig(), MatchingMethod::semi_global, 21, disparities, threads)};
  std::printf("| %d × %d × %d | %d | %.1f | %.1f | %.2f | %.1f | %.1f | %.2f |\n", scene.rig().width_px,
              scene.rig().height_px, disparities, threads, block_ms, ours_ms, ours_ms / block_ms, three_way_ms,
              ours_semi_global_ms, ours_semi_global_ms / three_way_ms);
}

}  // namespace

int main() {
  std::printf(
      "| image × disparities | threads | StereoBM 21 ms | correlation 21 ms | ratio | StereoSGBM 3WAY ms | "
      "semi_global ms | ratio |\n|---|---|---|---|---|---|---|---|\n");
  for (const int threads : {1, 2}) {
    compare("street?width=512&height=320", 64, threads);
    compare("street?width=1242&height=375", 128, threads);
  }
}
