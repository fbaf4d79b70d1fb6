// SPDX-License-Identifier: Apache-2.0
//
// Times our matcher and OpenCV's on the same pairs in one run and prints the ratios. Ours match two hypotheses
// (upright and road), OpenCV's one; all with sub-pixel, uniqueness and left-right test as each has them by default.
// All take turns, and the least of many times counts: of processor time on one thread, of time on more. Ours run with
// the machine's best instruction set and with AVX2.
#include <hwy/targets.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "backend/cpu.hpp"
#include "machine.hpp"
#include "matching/matching.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr int rounds{21};

double now_ms(int threads) {
  if (threads == 1) return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<double> least_ms(const std::vector<std::function<void()>>& works, int threads) {
  std::vector<double> least(works.size(), 1e9);
  for (int round{0}; round < rounds; ++round) {
    for (std::size_t i{0}; i < works.size(); ++i) {
      const double start{now_ms(threads)};
      works[i]();
      least[i] = std::min(least[i], now_ms(threads) - start);
    }
  }
  return least;
}

class Ours {
 public:
  Ours(const Rig& rig, int disparities, int threads)
      : config_{config_of(disparities)},
        plane_{road_plane(rig, {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad})},
        cpu_{threads},
        space_{rig.width_px, rig.height_px, config_, threads},
        matches_{rig.width_px, rig.height_px} {}

  void run(const StereoFrame& frame) {
    match(cpu_, frame.left.view(), frame.right.view(), plane_, config_, space_, matches_);
  }

 private:
  static MatchingConfig config_of(int disparities) {
    MatchingConfig config;
    config.window_px = 21;
    config.disparities = disparities;
    config.speckle_px = config.road_speckle_px = 0;  // OpenCV's default
    return config;
  }

  MatchingConfig config_;
  RoadPlane plane_;
  Cpu cpu_;
  MatchingWorkspace space_;
  Matches matches_;
};

cv::Mat mat_of(const Image<std::uint8_t>& image) {
  return cv::Mat{image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())};
}

void compare(const char* scene_text, int disparities, int threads, std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().DeInit();
  const scenes::Scene scene{scenes::parse_scene(scene_text)};
  const StereoFrame frame{scene.load(10)};
  cv::setNumThreads(threads);
  cv::Mat disparity;
  const auto block{cv::StereoBM::create(disparities, 21)};
  const auto three_way{
      cv::StereoSGBM::create(0, disparities, 5, 200, 800, 1, 0, 10, 100, 2, cv::StereoSGBM::MODE_SGBM_3WAY)};
  Ours correlation{scene.rig(), disparities, threads};
  const auto ms = least_ms({[&] { block->compute(mat_of(frame.left), mat_of(frame.right), disparity); },
                            [&] { three_way->compute(mat_of(frame.left), mat_of(frame.right), disparity); },
                            [&] { correlation.run(frame); }},
                           threads);
  std::printf("| %d × %d × %d | %s | %d | %.1f | %.1f | %.1f | %.2f | %.2f |\n", scene.rig().width_px,
              scene.rig().height_px, disparities, simd_target().data(), threads, ms[0], ms[1], ms[2], ms[2] / ms[0],
              ms[2] / ms[1]);
}

}  // namespace

int main() {
  print_machine();
  std::printf(
      "| image × disparities | instructions | threads | StereoBM 21 ms | StereoSGBM 3WAY ms | ours 21 ms | "
      "of StereoBM | of StereoSGBM |\n|---|---|---|---|---|---|---|---|\n");
  std::vector<std::int64_t> targets{0};
  if (simd_target() != "AVX2" && (hwy::SupportedTargets() & HWY_AVX2) != 0) targets.push_back(HWY_AVX2);
  for (const std::int64_t target : targets) {
    for (const int threads : {1, 2}) {
      compare("street?width=512&height=320", 64, threads, target);
      compare("street?width=1242&height=375", 128, threads, target);
    }
  }
}
