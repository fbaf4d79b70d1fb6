// SPDX-License-Identifier: Apache-2.0
//
// Times the whole chain, from images in memory to obstacles, stage by stage: wall-clock time on two threads, or as many
// as the second argument says, for the presets and both matchers, and as on a processor with AVX2 only, in turns, and
// on a GPU where there is one. The first argument is a recording, on a grid of 150 × 100 cells; without it, or empty, a
// built-in scene of the paper's size takes its place (512 × 320 px, 64 disparities, 100 × 100 cells).
#include <hwy/targets.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <vector>

#include "machine.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr int rounds{7};
constexpr std::size_t frames_max{60};
constexpr std::size_t warm_up_frames{8};

struct Stage {
  const char* name;
  double StageTimes::*milliseconds;
};
constexpr Stage stages[]{{"match", &StageTimes::match},   {"ground", &StageTimes::ground},
                         {"count", &StageTimes::count},   {"project", &StageTimes::project},
                         {"filter", &StageTimes::filter}, {"track", &StageTimes::track},
                         {"flow", &StageTimes::flow},     {"total", &StageTimes::total}};

std::vector<StereoFrame> frames_of(const FrameSource& source) {
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < std::min(source.size(), frames_max); ++i) frames.push_back(source.load(i));
  return frames;
}

std::unique_ptr<FrameSource> open(const char* recording) {
  if (recording != nullptr) return io::open_recording({{recording}, {}, {}});
  return std::make_unique<scenes::Scene>(scenes::parse_scene("street?width=512&height=320&focal=410"));
}

struct Setting {
  const char* name;
  const char* preset;
  MatchingMethod method;
  std::int64_t instructions{0};  ///< Highway target; 0: the machine's best
  BackEnd back_end{BackEnd::cpu};
  std::vector<StageTimes> times{};
};

void drive(const Rig& rig, const std::vector<StereoFrame>& frames, double length_m, int threads, Setting& setting) {
  hwy::SetSupportedTargetsForTest(setting.instructions);
  hwy::GetChosenTarget().DeInit();
  Config config{preset(setting.preset)};
  config.matching.method = setting.method;
  config.grid.length_m = length_m;
  Pipeline pipeline{config, rig, {.back_end = setting.back_end, .threads = threads, .stages = false}};
  for (std::size_t i{0}; i < frames.size(); ++i) {
    const StageTimes& taken{pipeline.process(frames[i]).timing_ms};
    if (i >= warm_up_frames) setting.times.push_back(taken);
  }
}

void print(const Setting& setting) {
  std::printf("| %s |", setting.name);
  for (const Stage& stage : stages) {
    std::vector<double> sorted;
    for (const StageTimes& one : setting.times) sorted.push_back(one.*stage.milliseconds);
    std::sort(sorted.begin(), sorted.end());
    std::printf(" %.2f / %.2f |", sorted.front(), sorted[sorted.size() / 2]);
  }
  std::printf("\n");
}

void run(const char* recording, int threads) {
  const std::unique_ptr<FrameSource> source{open(recording)};
  const std::vector<StereoFrame> frames{frames_of(*source)};
  std::vector<Setting> settings{{"default", "default", MatchingMethod::correlation},
                                {"default, semi-global", "default", MatchingMethod::semi_global},
                                {"paper", "paper", MatchingMethod::correlation}};
  if ((hwy::SupportedTargets() & HWY_AVX2) != 0) {
    settings.push_back({"default, AVX2", "default", MatchingMethod::correlation, HWY_AVX2});
    settings.push_back({"paper, AVX2", "paper", MatchingMethod::correlation, HWY_AVX2});
  }
  if (Pipeline{preset("default"), source->rig(), {.back_end = BackEnd::automatic}}.back_end() == BackEnd::cuda) {
    settings.push_back({"default, GPU", "default", MatchingMethod::correlation, 0, BackEnd::cuda});
    settings.push_back({"default, semi-global, GPU", "default", MatchingMethod::semi_global, 0, BackEnd::cuda});
    settings.push_back({"paper, GPU", "paper", MatchingMethod::correlation, 0, BackEnd::cuda});
  }
  for (int round{0}; round < rounds; ++round) {
    for (Setting& setting : settings) drive(source->rig(), frames, recording != nullptr ? 30 : 20, threads, setting);
  }
  std::printf("| least / median ms |");
  for (const Stage& stage : stages) std::printf(" %s |", stage.name);
  std::printf("\n|---|---|---|---|---|---|---|---|---|\n");
  for (const Setting& setting : settings) print(setting);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    print_machine();
    run(argc > 1 && argv[1][0] != '\0' ? argv[1] : nullptr, argc > 2 ? std::atoi(argv[2]) : 2);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_chain: %s\n", error.what());
    return 65;
  }
  return 0;
}
