// SPDX-License-Identifier: Apache-2.0
//
// Scaling of time and memory of the default chain from the paper's size on: image width and height, disparities, cells,
// velocities, threads and obstacles, one at a time; images and disparities together, up to 1920 × 1080 · 192. Also
// prints the expected gain of more threads by work and span, and frames per second of several cameras. Scene `street`;
// all sizes of a row in turns, two threads. The exponent is that of a power law through a row's medians.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "machine.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr int rounds{5};
constexpr std::size_t frames_each{24};
constexpr std::size_t warm_up_frames{8};

struct Setting {
  int width_px{512};
  int height_px{320};
  int focal_px{410};
  int disparities{64};
  double side_m{20};
  int speeds{6};
  int threads{2};
  int posts{0};  ///< posts on a road instead of the street's matches; 0: the street
};

struct Measured {
  std::vector<double> total_ms;
  std::size_t bytes{0};

  [[nodiscard]] double least_ms() const { return *std::min_element(total_ms.begin(), total_ms.end()); }
  [[nodiscard]] double median_ms() const {
    std::vector<double> sorted{total_ms};
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

Config config_of(const Setting& setting) {
  Config config{preset("default")};
  config.matching.disparities = setting.disparities;
  config.grid.length_m = config.grid.width_m = setting.side_m;
  std::vector<double>& speeds{config.filter.speeds_mps};
  while (static_cast<int>(speeds.size()) < setting.speeds) speeds.push_back(speeds.back() + 2);
  speeds.resize(static_cast<std::size_t>(setting.speeds));
  return config;
}

scenes::Scene scene_of(const Setting& setting) {
  return scenes::Scene{scenes::parse_scene("street?focal=" + std::to_string(setting.focal_px) +
                                           "&width=" + std::to_string(setting.width_px) +
                                           "&height=" + std::to_string(setting.height_px))};
}

std::vector<StereoFrame> frames_of(const scenes::Scene& scene) {
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < frames_each; ++i) frames.push_back(scene.load(i));
  return frames;
}

// Disparities of a road with posts of 0.1 to 0.2 m, in turns at 10 and 14 m, side by side.
Image<float> disparities_of_posts(const Rig& rig, int posts) {
  constexpr int pitch_px{8};
  constexpr double post_m{1.5};
  Image<float> disparities{rig.width_px, rig.height_px};
  for (int v{0}; v < rig.height_px; ++v) {
    const double below{v - rig.cy_px};
    for (int u{0}; u < rig.width_px; ++u) {
      const double distance_m{u / pitch_px % 2 == 0 ? 10.0 : 14.0};
      const double height_m{rig.camera_height_m - below * distance_m / rig.focal_px};
      const bool is_post{u / pitch_px < posts && u % pitch_px < pitch_px / 2 && height_m > 0 && height_m < post_m};
      const double depth_m{is_post ? distance_m : rig.camera_height_m * rig.focal_px / std::max(below, 1e-3)};
      const double d{rig.focal_px * rig.baseline_m / depth_m};
      disparities(u, v) = d >= 1 ? static_cast<float>(d) : 0.0F;
    }
  }
  return disparities;
}

std::vector<StereoFrame> frames_of(const Setting& setting, const scenes::Scene& scene) {
  std::vector<StereoFrame> frames{frames_of(scene)};
  if (setting.posts == 0) return frames;
  for (StereoFrame& frame : frames) {
    frame.disparity = disparities_of_posts(scene.rig(), setting.posts);
    frame.right = {};
    frame.left = frames.front().left;
    frame.world_from_vehicle = frames.front().world_from_vehicle;
  }
  return frames;
}

void drive(const Setting& setting, const Rig& rig, const std::vector<StereoFrame>& frames, Measured& measured) {
  Pipeline pipeline{config_of(setting), rig, {.threads = setting.threads, .stages = false}};
  for (std::size_t i{0}; i < frames.size(); ++i) {
    const FrameResult& result{pipeline.process(frames[i])};
    // wide images see obstacles beside the vehicle that are too close
    const bool is_close{std::ranges::equal(result.status, std::array{FrameStatus::too_close})};
    if (!result.warnings.empty() && !is_close) {
      throw std::runtime_error{"not what is measured: " + result.warnings.front().text};
    }
    if (i >= warm_up_frames) measured.total_ms.push_back(result.timing_ms.total);
  }
  measured.bytes = pipeline.memory_use().host_bytes;
}

// Slope of the line through the logarithms.
double exponent(const std::vector<double>& sizes, const std::vector<double>& values) {
  double mean_x{0};
  double mean_y{0};
  for (std::size_t i{0}; i < sizes.size(); ++i) {
    mean_x += std::log(sizes[i]) / static_cast<double>(sizes.size());
    mean_y += std::log(values[i]) / static_cast<double>(sizes.size());
  }
  double xy{0};
  double xx{0};
  for (std::size_t i{0}; i < sizes.size(); ++i) {
    xy += (std::log(sizes[i]) - mean_x) * (std::log(values[i]) - mean_y);
    xx += (std::log(sizes[i]) - mean_x) * (std::log(sizes[i]) - mean_x);
  }
  return xy / xx;
}

// `size`: what a setting counts as; the exponents are against it.
std::vector<Measured> print_row(const char* name, const std::vector<Setting>& settings,
                                const std::function<double(const Setting&)>& size) {
  std::vector<Measured> measured(settings.size());
  std::vector<Rig> rigs;
  std::vector<std::vector<StereoFrame>> frames;
  for (const Setting& setting : settings) {
    const scenes::Scene scene{scene_of(setting)};
    rigs.push_back(scene.rig());
    frames.push_back(frames_of(setting, scene));
  }
  for (int round{0}; round < rounds; ++round) {
    for (std::size_t i{0}; i < settings.size(); ++i) drive(settings[i], rigs[i], frames[i], measured[i]);
  }
  std::string sizes;
  std::string times;
  std::string bytes;
  std::vector<double> of_size;
  std::vector<double> of_time;
  std::vector<double> of_bytes;
  for (std::size_t i{0}; i < settings.size(); ++i) {
    char text[32];
    const auto add = [&](std::string& to, const char* format, double value) {
      std::snprintf(text, sizeof(text), format, value);
      to += (to.empty() ? "" : " / ") + std::string{text};
    };
    of_size.push_back(size(settings[i]));
    of_time.push_back(measured[i].median_ms());
    of_bytes.push_back(static_cast<double>(measured[i].bytes));
    add(sizes, "%.0f", of_size.back());
    add(times, "%.1f", of_time.back());
    add(bytes, "%.0f", of_bytes.back() / 1e6);
  }
  std::printf("| %s | %s | %s | %.2f | %s | %.2f |\n", name, sizes.c_str(), times.c_str(), exponent(of_size, of_time),
              bytes.c_str(), exponent(of_size, of_bytes));
  std::fflush(stdout);
  return measured;
}

// Fits T(p) = work/p + span to the least times of one and two threads.
void print_more_threads(double one_ms, double two_ms) {
  const double span_ms{std::max(2 * two_ms - one_ms, 0.0)};
  std::printf("\n| threads | ms, computed | faster than one |\n|---|---|---|\n");
  for (const int threads : {4, 8}) {
    const double ms{(one_ms - span_ms) / threads + span_ms};
    std::printf("| %d | %.1f | %.1f |\n", threads, ms, one_ms / ms);
  }
}

void print_growth() {
  std::printf("| what grows | sizes | median ms | exponent | MB | exponent |\n|---|---|---|---|---|---|\n");
  print_row("width, px", {{.width_px = 512}, {.width_px = 1024}, {.width_px = 2048}},
            [](const Setting& s) { return s.width_px; });
  print_row("height, px", {{.height_px = 320}, {.height_px = 640}, {.height_px = 1280}},
            [](const Setting& s) { return s.height_px; });
  print_row("disparities", {{.disparities = 64}, {.disparities = 128}, {.disparities = 256}},
            [](const Setting& s) { return s.disparities; });
  print_row("million pixels · disparities: 512 × 320 · 64, 1242 × 375 · 128, 1920 × 1080 · 192",
            {{},
             {.width_px = 1242, .height_px = 375, .focal_px = 720, .disparities = 128},
             {.width_px = 1920, .height_px = 1080, .focal_px = 1540, .disparities = 192}},
            [](const Setting& s) { return 1e-6 * s.width_px * s.height_px * s.disparities; });
  print_row("cells of the grid", {{.side_m = 20}, {.side_m = 40}, {.side_m = 80}},
            [](const Setting& s) { return 25 * s.side_m * s.side_m; });
  print_row("velocities", {{.speeds = 3}, {.speeds = 6}, {.speeds = 12}},
            [](const Setting& s) { return (2 * s.speeds + 1) * (2 * s.speeds + 1); });
  print_row("obstacles, without matching", {{.posts = 4}, {.posts = 16}, {.posts = 64}},
            [](const Setting& s) { return s.posts; });
  const std::vector<Measured> of_threads{
      print_row("threads", {{.threads = 1}, {.threads = 2}}, [](const Setting& s) { return s.threads; })};
  print_more_threads(of_threads[0].least_ms(), of_threads[1].least_ms());
}

// Frames per second of all cameras, processed by `work` once for each instant.
double rate_of(std::size_t cameras, const std::function<void(std::size_t)>& work) {
  for (std::size_t i{0}; i < warm_up_frames; ++i) work(i);
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i{warm_up_frames}; i < frames_each; ++i) work(i);
  const std::chrono::duration<double> taken{std::chrono::steady_clock::now() - start};
  return static_cast<double>(cameras * (frames_each - warm_up_frames)) / taken.count();
}

double camera_rate(std::size_t cameras, bool in_turns, const Rig& rig, const std::vector<StereoFrame>& frames) {
  std::vector<Pipeline> pipelines;
  for (std::size_t c{0}; c < cameras; ++c)
    pipelines.emplace_back(preset("default"), rig, PipelineOptions{.stages = false});
  return rate_of(cameras, [&](std::size_t i) {
    std::vector<std::thread> threads;
    for (Pipeline& pipeline : pipelines) {
      if (in_turns) {
        pipeline.process(frames[i]);
      } else {
        threads.emplace_back([&] { pipeline.process(frames[i]); });
      }
    }
    for (std::thread& thread : threads) thread.join();
  });
}

void print_cameras() {
  const scenes::Scene scene{scene_of({})};
  const std::vector<StereoFrame> frames{frames_of(scene)};
  std::printf("\n| cameras | frames/s of all, in turns | a thread each |\n|---|---|---|\n");
  for (const std::size_t cameras : {1U, 2U, 4U, 8U}) {
    double best[2]{};
    for (int round{0}; round < rounds; ++round) {
      for (const bool in_turns : {true, false}) {
        double& of_way{best[in_turns ? 0 : 1]};
        of_way = std::max(of_way, camera_rate(cameras, in_turns, scene.rig(), frames));
      }
    }
    std::printf("| %zu | %.0f | %.0f |\n", cameras, best[0], best[1]);
    std::fflush(stdout);
  }
}

}  // namespace

int main() {
  print_machine();
  print_growth();
  print_cameras();
  return 0;
}
