// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/terrain.hpp"

namespace stereogrid::evaluation::testing {
namespace {

constexpr int length{80};
constexpr int width{10};

/// Cells of 0.2 m, each row as the text says from 0 m ahead on: '.' hidden, 'd' drivable, 'o' object, 'r' rise, 'e'
/// drop, 'b' beyond. Later cells are hidden.
FrameTruth truth_of(const std::string& row, float step_m = 0) {
  FrameTruth truth;
  truth.terrain = {length, width};
  truth.step_m = {length, width};
  truth.pixels = {length, width};
  truth.seen_object = {length, width};
  for (int iy{0}; iy < width; ++iy) {
    for (int ix{0}; ix < static_cast<int>(row.size()); ++ix) {
      const char c{row[static_cast<std::size_t>(ix)]};
      const TerrainCell cell{c == 'd'               ? TerrainCell::drivable
                             : c == 'o' || c == 'r' ? TerrainCell::obstacle
                             : c == 'e'             ? TerrainCell::drop
                             : c == 'b'             ? TerrainCell::beyond
                                                    : TerrainCell::hidden};
      truth.terrain(ix, iy) = static_cast<std::uint8_t>(cell);
      truth.pixels(ix, iy) = c == 'o' ? 30 : 0;
      truth.seen_object(ix, iy) = c == 'o' ? 1 : 0;
      truth.step_m(ix, iy) = c == 'r' || c == 'e' ? step_m : 0;
    }
  }
  return truth;
}

const TruthGrid truth_grid{{0, -1, 0.2, length, width}};

/// Probabilities, each row as the text says: '0' free, '1' occupied, else unknown.
Image<float> grid_of(const std::string& row) {
  Image<float> grid{length, width, 0.5F};
  for (int iy{0}; iy < width; ++iy) {
    for (int ix{0}; ix < static_cast<int>(row.size()); ++ix) {
      const char c{row[static_cast<std::size_t>(ix)]};
      grid(ix, iy) = c == '0' ? 0.1F : c == '1' ? 0.9F : 0.5F;
    }
  }
  return grid;
}

TerrainSummary summary_of(const std::string& truth, const std::string& grid) {
  TerrainScores scores;
  scores.add(grid_of(grid).view(), truth_grid.geometry, truth_of(truth, -0.5F), truth_grid);
  return scores.summary();
}

double share(const TerrainSummary& summary, std::string_view name, std::size_t range = 0) {
  for (const TerrainMetric& metric : terrain_metrics) {
    if (metric.name != name) continue;
    const TerrainCounts& counts{summary.ranges[range]};
    return static_cast<double>(counts.*metric.part) / static_cast<double>(counts.*metric.whole);
  }
  return -1;
}

//                                 0         1         2         3
//                                 0123456789012345678901234567890123
constexpr const char* scene_row{"....ddddddddooddddrrddddddddddebbbbb"};

TEST(TerrainScores, APerfectGrid) {
  const TerrainSummary s{summary_of(scene_row, "....0000000011000011000000000 1")};
  EXPECT_EQ(s.frames, 1U);
  EXPECT_EQ(s.scale.tolerance_m, 0.4);
  EXPECT_EQ(share(s, "drivable_free"), 1);
  EXPECT_EQ(share(s, "drivable_occupied"), 0);
  EXPECT_EQ(share(s, "objects_found"), 1);
  EXPECT_EQ(share(s, "rises_found"), 1);
  EXPECT_EQ(share(s, "edges_found"), 1);
  EXPECT_EQ(share(s, "deadly_share"), 0);
  EXPECT_EQ(s.ranges[0].drivable, 10U * (8 + 4 + 8)) << "two cells before the edge are left out";
  EXPECT_EQ(s.ranges[0].objects, 1U);
  EXPECT_EQ(s.ranges[0].deadly, 10U * (2 + 2 + 4)) << "of five cells beyond, the first is within the tolerance";
}

TEST(TerrainScores, AGridThatIsFreeEverywhereIsDeadly) {
  const TerrainSummary s{summary_of(scene_row, std::string(length, '0'))};
  EXPECT_EQ(share(s, "drivable_free"), 1);
  EXPECT_EQ(share(s, "objects_found"), 0);
  EXPECT_EQ(share(s, "rises_found"), 0);
  EXPECT_EQ(share(s, "edges_found"), 0);
  EXPECT_EQ(share(s, "deadly_share"), 1);
}

TEST(TerrainScores, AnUnknownGridIsUselessButNotDeadly) {
  const TerrainSummary s{summary_of(scene_row, "")};
  EXPECT_EQ(share(s, "drivable_free"), 0);
  EXPECT_EQ(share(s, "edges_found"), 0);
  EXPECT_EQ(share(s, "deadly_share"), 0);
}

TEST(TerrainScores, TheToleranceIsTwoCells) {
  EXPECT_EQ(share(summary_of("ddddddddebbbb", "00000010"), "edges_found"), 1);
  EXPECT_EQ(share(summary_of("ddddddddebbbb", "0000010"), "edges_found"), 0);
  EXPECT_EQ(share(summary_of("ddddddddrr", "0000000000"), "deadly_share"), 1);
  EXPECT_EQ(share(summary_of("ddddddddrr", "0000000001"), "deadly_share"), 0) << "a cell off is not a miss";
}

TEST(TerrainScores, RangesAreApart) {
  std::string row(39, 'd');
  const TerrainSummary s{summary_of(row + "ddddd", std::string(39, '0') + "01111")};
  EXPECT_EQ(share(s, "drivable_free", 0), 1);
  EXPECT_EQ(share(s, "drivable_occupied", 1), 1);
  EXPECT_EQ(s.ranges[1].drivable, 40U);
  EXPECT_EQ(terrain_scale(0.05).ranges[1].to_m, 4);
  EXPECT_EQ(terrain_scale(0.05).tolerance_m, 0.1);
}

TEST(TerrainScores, SmallestStepWithAllLargerOnes) {
  TerrainScores scores;
  const auto add{[&](const char* grid, float step_m) {
    scores.add(grid_of(grid).view(), truth_grid.geometry, truth_of("ddddddddr", step_m), truth_grid);
  }};
  add("000000001", 0.3F);
  add("000000001", 0.2F);
  add("00000000", 0.15F);
  add("000000001", 0.1F);
  add("00000000", -0.2F);
  add("000000001", -0.4F);
  const TerrainSummary s{scores.summary()};
  ASSERT_EQ(s.steps.size(), 1U);
  EXPECT_EQ(s.steps[0].range.to_m, 3.25);
  EXPECT_EQ(s.steps[0].up_m, 0.2);
  EXPECT_EQ(s.steps[0].down_m, 0.4);
  TerrainScores one;
  one.add(grid_of("").view(), truth_grid.geometry, truth_of("ddddddddr", 0.3F), truth_grid);
  EXPECT_TRUE(one.summary().steps.empty());
}

TEST(TerrainScores, TheGridMayLieElsewhere) {
  TerrainScores scores;
  const GridGeometry shifted{0.4, -1, 0.2, length, width};
  scores.add(grid_of("00000001").view(), shifted, truth_of("dddddddddebb"), truth_grid);
  EXPECT_EQ(share(scores.summary(), "edges_found"), 1);
  EXPECT_EQ(scores.summary().ranges[0].drivable, 10U * 5) << "two cells lie outside the grid, two at the edge";
  const GridGeometry other{0, -1, 0.25, length, width};
  EXPECT_THROW(scores.add(grid_of("").view(), other, truth_of("d"), truth_grid), InputError);
}

TEST(TerrainScores, OfTheZonesOfACourse) {
  TruthGrid course{truth_grid};
  course.zones = {
      {"edge", true, {11.6, -1}, {14, 1}}, {"kerb", true, {13, 5}, {14, 6}}, {"hump", false, {10, -1}, {11, 1}}};
  TerrainScores scores;
  FrameTruth truth{truth_of("dddddddddebbbbb")};
  truth.ego.world_from_vehicle = {10, 0, 0};
  scores.add(grid_of("000100000100000").view(), truth_grid.geometry, truth, course);
  scores.add(grid_of("00010000000000").view(), truth_grid.geometry, truth, course);
  const std::vector<ZoneScore> zones{scores.summary().zones};
  ASSERT_EQ(zones.size(), 2U) << "the kerb was not seen";
  EXPECT_EQ(zones[0].marks, 2U * width);
  EXPECT_EQ(zones[0].marks_found, 1U * width);
  EXPECT_TRUE(zones[0].is_found());
  EXPECT_EQ(zones[0].deadly, 2U * 4 * width);
  EXPECT_EQ(zones[0].deadly_free, (4U + 3U) * width);
  EXPECT_EQ(zones[1].drivable, 2U * 5 * width);
  EXPECT_EQ(zones[1].drivable_occupied, 2U * width);
  EXPECT_TRUE(zones[1].is_false());
}

TEST(TerrainScores, FramesWithoutTruthAreSkipped) {
  TerrainScores scores;
  scores.add(grid_of("0").view(), truth_grid.geometry, FrameTruth{}, truth_grid);
  EXPECT_EQ(scores.summary().frames, 0U);
}

/// Cells of a row: 'f' labelled free, 'o' occupied, else not scored; 'g', 'm', 's' witnesses, else none.
WitnessSummary witnessed(const std::string& labelled, const std::string& witnesses, const std::string& grid) {
  Labels labels;
  labels.cells = {length, width, not_scored};
  Image<CellWitness> witness{length, width};
  for (std::size_t i{0}; i < labelled.size(); ++i) {
    const int ix{static_cast<int>(i)};
    labels.cells(ix, 5) = labelled[i] == 'f' ? labelled_free : labelled[i] == 'o' ? labelled_occupied : not_scored;
    witness(ix, 5) = CellWitness::of(witnesses[i] == 'g'   ? Witness::ground
                                     : witnesses[i] == 'm' ? Witness::memory
                                     : witnesses[i] == 's' ? Witness::source
                                                           : Witness::none);
  }
  WitnessScores scores;
  scores.add(grid_of(grid).view(), witness.view(), labels);
  scores.add(grid_of(grid).view(), Image<CellWitness>{}.view(), labels);  // a run without witnesses
  return scores.summary();
}

TEST(WitnessScores, CountFreeCellsByTheirWitness) {
  const WitnessSummary all_free{witnessed("ffff.fo", "ggms.gg", "0000001")};
  EXPECT_EQ(all_free.ground, 3U);
  EXPECT_EQ(all_free.memory, 1U);
  EXPECT_EQ(all_free.source, 1U);
  EXPECT_EQ(all_free.frames, 1U);
  EXPECT_EQ(all_free.failed, 0U);
  EXPECT_EQ(all_free.failed_at_most, 1) << "three of one frame";
  const WitnessSummary wrong{witnessed("oooff", "gmsgg", "00000")};
  EXPECT_EQ(wrong.ground_occupied, 1U);
  EXPECT_EQ(wrong.memory_occupied, 1U);
  EXPECT_EQ(wrong.source_occupied, 1U);
  EXPECT_EQ(wrong.failed, 1U);
  EXPECT_TRUE(std::isnan(wrong.failed_at_most));
  EXPECT_EQ(witnessed("of", "gg", "01").failed, 0U) << "a cell off is not a miss";
  EXPECT_EQ(witnessed("off", "ggg", "001").failed, 1U);
}

}  // namespace
}  // namespace stereogrid::evaluation::testing
