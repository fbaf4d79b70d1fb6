// SPDX-License-Identifier: Apache-2.0
#include "matching/semi_global/semi_global.hpp"
#include "matching_run.hpp"
#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

struct Descriptors {
  Image<std::uint32_t> left, right, sheared;

  [[nodiscard]] CensusTriple census() const { return {left.view(), right.view(), sheared.view()}; }
};

int up_to(int last, std::mt19937& generator) {
  return std::uniform_int_distribution<int>{0, last}(generator);
}

// Noise; few different descriptors, so that costs tie; or mostly flat.
Descriptors random_descriptors(int width, int height, std::mt19937& generator) {
  const int kind{up_to(2, generator)};
  Descriptors descriptors{{width, height}, {width, height}, {width, height}};
  for (Image<std::uint32_t>* image : {&descriptors.left, &descriptors.right, &descriptors.sheared}) {
    for (std::uint32_t& bits : *image) {
      const auto noise = static_cast<std::uint32_t>(generator()) & 0x7fffffffu;
      bits = kind == 0 ? noise : (kind == 1 ? 1u << noise % 4 : (noise % 8 == 0 ? noise : 0u));
    }
  }
  return descriptors;
}

MatchingConfig random_config(int disparities_max, std::mt19937& generator) {
  MatchingConfig config;
  config.method = MatchingMethod::semi_global;
  config.disparities = 2 + up_to(disparities_max - 2, generator);
  config.left_right_px = up_to(2, generator);
  config.uniqueness = up_to(200, generator) / 1000.0;
  return config;
}

// Their labels meet the upright ones inside, at either end of and beyond the disparities; some rows have no road.
RoadPlane random_plane(std::mt19937& generator) {
  return {up_to(1000, generator) / 10.0 - 10, up_to(200, generator) / 1000.0 - 0.1,
          up_to(600, generator) / 1000.0 - 0.1, 10, 10};
}

struct Found {
  Found(int width, int height) : upright{width, height}, level{width, height} {}

  Image<Candidate> upright, level;
};

int differences(const Image<Candidate>& a, const Image<Candidate>& b) {
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += a.data()[i] == b.data()[i] ? 0 : 1;
  return different;
}

void expect_equal_on_random_problems(int count, int disparities_max, unsigned seed) {
  std::mt19937 generator{seed};
  Cpu cpus[]{Cpu{1}, Cpu{2}, Cpu{5}};
  std::vector<std::uint8_t> memory;
  for (int i{0}; i < count; ++i) {
    const int width{1 + up_to(i % 8 == 0 ? 150 : 40, generator)};
    const int height{1 + up_to(20, generator)};
    const Descriptors descriptors{random_descriptors(width, height, generator)};
    const MatchingConfig config{random_config(disparities_max, generator)};
    const RoadPlane plane{random_plane(generator)};
    Reference reference;
    Found expected{width, height};
    Found found{width, height};
    Recorder expected_recorder{expected.upright, expected.level};
    Recorder recorder{found.upright, found.level};
    Cpu& cpu{cpus[i % 3]};
    std::vector<RowCandidates> rows(static_cast<std::size_t>(cpu.threads()), RowCandidates{width});
    optimise(reference, descriptors.census(), plane, config, expected_recorder);
    optimise(cpu, descriptors.census(), plane, config, memory, rows, recorder);
    const auto where = testing::Message() << width << " × " << height << ", disparities " << config.disparities
                                          << ", plane " << plane.at_centre << " " << plane.per_u << " " << plane.per_v;
    ASSERT_EQ(differences(expected.upright, found.upright), 0) << where;
    ASSERT_EQ(differences(expected.level, found.level), 0) << where;
  }
}

TEST(SemiGlobal, RoadLabelsMeetTheUprightOnesOfTheSameDisparity) {
  const RoadPlane plane{20.3, 0, 0, 0, 0};
  EXPECT_EQ(meeting_label(plane, {0, 64}, road_shifts, 10, 10), 17);
  EXPECT_EQ(meeting_label(plane, {0, 24}, road_shifts, 10, 10), -1) << "labels 17 to 23 are not all there";
  EXPECT_EQ(meeting_label({2, 0, 0, 0, 0}, {0, 64}, road_shifts, 10, 10), -1);
}

TEST(SemiGlobal, CpuEqualsReference) {
  expect_equal_on_random_problems(150, 100, 3);
  expect_equal_on_random_problems(40, 256, 5);
}

TEST(SemiGlobal, CpuEqualsReferenceOnEveryTarget) {
  for (const std::int64_t target : vector_targets()) {
    SCOPED_TRACE(name_of_target(target));
    const ForcedTarget forced{target};
    expect_equal_on_random_problems(60, 256, 7);
  }
}

// The whole of `match`, and images smaller than the disparities.
TEST(SemiGlobal, MatchEqualsReference) {
  std::mt19937 generator{89};
  for (const int width : {1, 3, 33, 61}) {
    MatchingConfig config{random_config(70, generator)};
    config.texture = 3;
    config.speckle_px = config.road_speckle_px = 4;
    const RoadPlane plane{3.3, 0.07, 0.31, 30, 10};
    const Image<std::uint8_t> left{noise_image(width, 17, generator)};
    const Image<std::uint8_t> right{noise_image(width, 17, generator)};
    Reference reference;
    Cpu cpu{2};
    const MatchRun slow{reference, left, right, plane, config};
    const MatchRun fast{cpu, left, right, plane, config};
    EXPECT_EQ(count_differences(slow.matches.obstacle, fast.matches.obstacle), 0) << width;
    EXPECT_EQ(count_differences(slow.matches.road, fast.matches.road), 0) << width;
  }
}

}  // namespace
}  // namespace stereogrid::test
