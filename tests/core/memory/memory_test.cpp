// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The pipeline's held bytes equal those of malloc, before the first frame and after ten.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "allocations.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::test {
namespace {

constexpr std::size_t frames{10};
// The program's other parts allocate little beside: what oneTBB keeps, and malloc's own rounding.
constexpr double error_max{0.005};

struct Case {
  const char* name;
  std::vector<std::pair<const char*, const char*>> settings{};
  int threads{2};
  std::vector<double> horizons_s{};
  bool is_masked{false};
};

void PrintTo(const Case& one, std::ostream* out) {
  *out << one.name;
}

class Memory : public testing::TestWithParam<Case> {};

TEST_P(Memory, IsWhatThePipelineSays) {
  if (!can_count_allocations()) GTEST_SKIP() << "malloc cannot be counted under a sanitizer, nor without glibc";
  const Case& one{GetParam()};
  const scenes::Scene scene{scenes::parse_scene("street?width=320&height=160&frames=10"), 2};
  std::vector<StereoFrame> recording;
  for (std::size_t i{0}; i < frames; ++i) recording.push_back(scene.load(i));
  Config config{preset("default")};
  for (const auto& [key, value] : one.settings) set(config, key, value);

  Image<std::uint8_t> mask;
  if (one.is_masked) mask = Image<std::uint8_t>{320, 160, 1};
  if (one.is_masked) mask(160, 150) = 0;
  const std::ptrdiff_t before{live_bytes()};
  Pipeline pipeline{config, scene.rig(), {.threads = one.threads, .horizons_s = one.horizons_s, .mask = mask}};
  const auto said{static_cast<double>(pipeline.memory_use().host_bytes)};
  EXPECT_NEAR(static_cast<double>(live_bytes() - before), said, error_max * said) << "at construction";
  for (const StereoFrame& frame : recording) pipeline.process(frame);
  EXPECT_NEAR(static_cast<double>(live_bytes() - before), said, error_max * said) << "after ten frames";
  EXPECT_EQ(static_cast<double>(pipeline.memory_use().host_bytes), said);
  EXPECT_EQ(pipeline.memory_use().device_bytes, 0u);
  RecordProperty("bytes", std::to_string(pipeline.memory_use().host_bytes));
}

INSTANTIATE_TEST_SUITE_P(, Memory,
                         testing::Values(Case{.name = "Default"}, Case{.name = "FiveThreads", .threads = 5},
                                         Case{.name = "SemiGlobal", .settings = {{"matching.method", "semi_global"}}},
                                         Case{.name = "Tay2008", .settings = {{"filter.model", "tay2008"}}},
                                         // with little else, so that the small things count
                                         Case{.name = "FewVelocities", .settings = {{"filter.speeds_mps", "1.25"}}},
                                         Case{.name = "Bins", .settings = {{"projection.model", "bins"}}},
                                         Case{.name = "Predictions", .horizons_s = {0.5, 1}},
                                         // the mask and its level image: 0.1 MB of 11
                                         Case{.name = "Masked", .is_masked = true}),
                         [](const auto& one) { return std::string{one.param.name}; });

TEST(MemoryOfPipelines, OfALargerPipelineIsMore) {
  const Rig rig{scenes::Scene{scenes::parse_scene("street?width=320&height=160&frames=1"), 1}.rig()};
  const auto bytes = [&](const char* key, const char* value) {
    Config config{preset("default")};
    set(config, key, value);
    return Pipeline{config, rig, {.threads = 1}}.memory_use().host_bytes;
  };
  EXPECT_GT(bytes("grid.length_m", "30"), bytes("grid.length_m", "20"));
  EXPECT_GT(bytes("filter.speeds_mps", "1,2,4,8"), bytes("filter.speeds_mps", "1"));
}

}  // namespace
}  // namespace stereogrid::test
