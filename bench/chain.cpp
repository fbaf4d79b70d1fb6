// SPDX-License-Identifier: Apache-2.0
//
// Times the whole chain, from images in memory to obstacles, stage by stage: wall-clock time on two threads, or as many
// as the second argument says, for the presets, and as on a processor with AVX2 only, in turns, and
// on a GPU where there is one; `after grids`: the time in which only obstacles are missing. The first argument is a
// recording, on a grid of 150 × 100 cells; without it, or empty, a built-in scene of the paper's size takes its place
// (512 × 320 px, 64 disparities, 100 × 100 cells).
//
// bench_chain RECORDING THREADS 1,4,16: instead, this number of pipelines of the preset `default` side by side on the
// CPU, and on a GPU where there is one. Each has a thread that calls it, and THREADS for its work on the host.
#include <hwy/targets.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <future>
#include <latch>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "machine.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr int rounds{7};
constexpr std::size_t frames_max{60};
constexpr std::size_t warm_up_frames{8};

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>{Clock::now() - begin}.count();
}

double percentile(std::vector<double> values, std::size_t percent) {
  std::sort(values.begin(), values.end());
  return values[values.size() * percent / 100];
}

struct FrameTimes : StageTimes {
  double after_grids{0};
};

struct Stage {
  const char* name;
  double FrameTimes::*milliseconds;
};
constexpr Stage stages[]{
    {"match", &StageTimes::match},     {"ground", &StageTimes::ground},           {"count", &StageTimes::count},
    {"project", &StageTimes::project}, {"filter", &StageTimes::filter},           {"track", &StageTimes::track},
    {"flow", &StageTimes::flow},       {"after grids", &FrameTimes::after_grids}, {"total", &StageTimes::total}};

std::vector<StereoFrame> frames_of(const FrameSource& source) {
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < std::min(source.size(), frames_max); ++i) frames.push_back(source.load(i));
  if (frames.size() <= warm_up_frames) throw InputError{"the recording has too few frames to be measured."};
  return frames;
}

std::unique_ptr<FrameSource> open(const char* recording) {
  if (recording != nullptr) return io::open_recording({{recording}, {}, {}});
  return std::make_unique<scenes::Scene>(scenes::parse_scene("street?width=512&height=320&focal=410"));
}

struct Setting {
  const char* name;
  const char* preset;
  std::int64_t instructions{0};  ///< Highway target; 0: the machine's best
  BackEnd back_end{BackEnd::cpu};
  std::vector<FrameTimes> times{};
};

bool has_gpu(const Rig& rig) {
  return Pipeline{preset("default"), rig, {.back_end = BackEnd::automatic}}.back_end() == BackEnd::cuda;
}

void drive(const Rig& rig, const std::vector<StereoFrame>& frames, double length_m, int threads, Setting& setting) {
  hwy::SetSupportedTargetsForTest(setting.instructions);
  hwy::GetChosenTarget().DeInit();
  Config config{preset(setting.preset)};
  config.grid.length_m = length_m;
  Clock::time_point has_grids;
  FrameTimes taken;
  PipelineOptions options{.back_end = setting.back_end, .threads = threads, .stages = false};
  options.on_grids = [&has_grids](const FrameResult&) { has_grids = Clock::now(); };
  Pipeline pipeline{config, rig, options};
  for (std::size_t i{0}; i < frames.size(); ++i) {
    static_cast<StageTimes&>(taken) = pipeline.process(frames[i]).timing_ms;
    taken.after_grids = milliseconds_since(has_grids);
    if (i >= warm_up_frames) setting.times.push_back(taken);
  }
}

void print(const Setting& setting) {
  std::printf("| %s |", setting.name);
  for (const Stage& stage : stages) {
    std::vector<double> values;
    for (const FrameTimes& one : setting.times) values.push_back(one.*stage.milliseconds);
    std::printf(" %.2f / %.2f |", percentile(values, 0), percentile(values, 50));
  }
  std::printf("\n");
}

void run(const FrameSource& source, double length_m, int threads) {
  const std::vector<StereoFrame> frames{frames_of(source)};
  std::vector<Setting> settings{{"default", "default"}, {"paper", "paper"}};
  if ((hwy::SupportedTargets() & HWY_AVX2) != 0) {
    settings.push_back({"default, AVX2", "default", HWY_AVX2});
    settings.push_back({"paper, AVX2", "paper", HWY_AVX2});
  }
  if (has_gpu(source.rig())) {
    settings.push_back({"default, GPU", "default", 0, BackEnd::cuda});
    settings.push_back({"paper, GPU", "paper", 0, BackEnd::cuda});
  }
  for (int round{0}; round < rounds; ++round) {
    for (Setting& setting : settings) drive(source.rig(), frames, length_m, threads, setting);
  }
  std::printf("| least / median ms |");
  for (const Stage& stage : stages) std::printf(" %s |", stage.name);
  std::printf("\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Setting& setting : settings) print(setting);
}

struct Cameras {
  std::vector<double> times_ms;  ///< each frame's
  double frames_per_s;           ///< frames of all cameras
};

Cameras run_cameras(std::vector<Pipeline>& pipelines, const std::vector<StereoFrame>& frames) {
  std::latch start{static_cast<std::ptrdiff_t>(pipelines.size()) + 1};
  const auto run_one = [&](Pipeline& pipeline) {
    std::vector<double> times_ms;
    start.arrive_and_wait();
    for (std::size_t i{warm_up_frames}; i < frames.size(); ++i) {
      const Clock::time_point begin{Clock::now()};
      pipeline.process(frames[i]);
      times_ms.push_back(milliseconds_since(begin));
    }
    return times_ms;
  };
  std::vector<std::future<std::vector<double>>> running;
  for (Pipeline& pipeline : pipelines)
    running.push_back(std::async(std::launch::async, [&run_one, &pipeline] { return run_one(pipeline); }));
  start.arrive_and_wait();
  const Clock::time_point begin{Clock::now()};
  Cameras cameras{};
  for (std::future<std::vector<double>>& one : running) {
    const std::vector<double> times_ms{one.get()};
    cameras.times_ms.insert(cameras.times_ms.end(), times_ms.begin(), times_ms.end());
  }
  cameras.frames_per_s = 1e3 * static_cast<double>(cameras.times_ms.size()) / milliseconds_since(begin);
  return cameras;
}

void run_side_by_side(const FrameSource& source, double length_m, int threads, const std::string& counts) {
  const std::vector<StereoFrame> frames{frames_of(source)};
  Config config{preset("default")};
  config.grid.length_m = length_m;
  std::printf("| back end | pipelines | frames/s of all | median ms | 99 %% ms |\n|---|---:|---:|---:|---:|\n");
  for (const BackEnd back_end : {BackEnd::cpu, BackEnd::cuda}) {
    if (back_end == BackEnd::cuda && !has_gpu(source.rig())) continue;
    std::istringstream all{counts};
    for (std::string count; std::getline(all, count, ',');) {
      std::vector<Pipeline> pipelines;
      for (int i{0}; i < std::stoi(count); ++i) {
        pipelines.emplace_back(config, source.rig(),
                               PipelineOptions{.back_end = back_end, .threads = threads, .stages = false});
        for (std::size_t f{0}; f < warm_up_frames; ++f) pipelines.back().process(frames[f]);
      }
      const Cameras cameras{run_cameras(pipelines, frames)};
      std::printf("| %s | %s | %.0f | %.2f | %.2f |\n", back_end == BackEnd::cuda ? "GPU" : "CPU", count.c_str(),
                  cameras.frames_per_s, percentile(cameras.times_ms, 50), percentile(cameras.times_ms, 99));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    print_machine();
    const char* const recording{argc > 1 && argv[1][0] != '\0' ? argv[1] : nullptr};
    const std::unique_ptr<FrameSource> source{open(recording)};
    const double length_m{recording != nullptr ? 30.0 : 20.0};
    const int threads{argc > 2 ? std::atoi(argv[2]) : 2};
    if (argc > 3) {
      run_side_by_side(*source, length_m, threads, argv[3]);
    } else {
      run(*source, length_m, threads);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_chain: %s\n", error.what());
    return 65;
  }
  return 0;
}
