// SPDX-License-Identifier: Apache-2.0
//
// Masses for each velocity are kept only where something moves (docs/method.md §8.7).
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "pipeline/saved_state.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr int cells{120};
constexpr GridGeometry geometry{0, 0, 0.2, cells, cells};

// A car of 4 × 4 cells that goes a cell a step, and a wall.
Image<float> street(int step) {
  Image<float> observed{scene(cells, 10 + step, 50, 4, 4, 0.9f, 0.1f)};
  for (int x{0}; x < cells; ++x) observed(x, 80) = observed(x, 81) = 0.9f;
  for (int y{90}; y < cells; ++y) std::fill_n(observed.row(y), cells, 0.5f);
  return observed;
}

int blocks_with_masses(const FilterState& state) {
  int count{0};
  for (int block{0}; block < state.blocks.layout().count(); ++block) count += state.blocks.slot(block) >= 0 ? 1 : 0;
  return count;
}

// Every block has masses.
template <class BackEndType>
void keep_all(FilterRun<BackEndType>& run) {
  run.tables.moving_from = {-1, -1};
}

TEST(MovingBlocks, FollowWhatMoves) {
  Cpu cpu{2};
  FilterRun run{cpu, FilterConfig{}, geometry};
  for (int step{0}; step < 60; ++step) run.step(street(step));
  EXPECT_NE(run.now.blocks.masses_at(71, 52), nullptr) << "where the car is";
  EXPECT_EQ(run.now.blocks.masses_at(11, 52), nullptr) << "where it was";
  EXPECT_EQ(run.now.blocks.masses_at(100, 20), nullptr) << "free ground";
  EXPECT_EQ(run.now.blocks.masses_at(100, 80), nullptr) << "the wall";
  EXPECT_EQ(run.now.blocks.masses_at(100, 110), nullptr) << "never seen";
  EXPECT_LE(blocks_with_masses(run.now), 16);
}

TEST(MovingBlocks, ChangeLittleOfWhatAllBlocksWouldSay) {
  Cpu cpu{2};
  FilterRun sparse{cpu, FilterConfig{}, geometry};
  FilterRun all{cpu, FilterConfig{}, geometry};
  keep_all(all);
  for (int step{0}; step < 40; ++step) {
    sparse.step(street(step));
    all.step(street(step));
    double difference{0};
    for (const auto [x, y] : raster(cells, cells)) {
      difference += std::abs(sparse.layers.occupancy(x, y) - all.layers.occupancy(x, y));
    }
    EXPECT_LT(difference / (cells * cells), 0.002) << step;
  }
  EXPECT_EQ(blocks_with_masses(all.now), all.now.blocks.layout().count());
  const double of_the_car{mean_over(all.layers.velocity_x, 49, 50, 4, 4)};
  EXPECT_NEAR(mean_over(sparse.layers.velocity_x, 49, 50, 4, 4), of_the_car, 0.1);
}

// Evenly spread moving mass continues as the sum over all velocities: the same as if each were stored.
TEST(MovingBlocks, SpreadEvenlyIsTheSumOverAllVelocities) {
  Reference reference;
  for (const double dt_s : {0.1, 0.13, 0.5}) {
    FilterRun even{reference, FilterConfig{}, {0, 0, 0.2, 40, 40}};
    FilterRun all{reference, FilterConfig{}, {0, 0, 0.2, 40, 40}};
    keep_all(all);
    even.step(scene(40, 8, 8, 9, 12, 0.6f, 0.2f));
    all.now = even.now;  // the masses are alike
    const GridGeometry moved{0.4, -0.2, 0.2, 40, 40};
    even.step(Image<float>{40, 40, 0.5f}, dt_s, moved);
    all.step(Image<float>{40, 40, 0.5f}, dt_s, moved);
    ASSERT_EQ(blocks_with_masses(even.now), 0);
    for (const auto [x, y] : raster(40, 40)) {
      ASSERT_NEAR(even.layers.occupancy(x, y), all.layers.occupancy(x, y), 1e-6) << x << " " << y << " " << dt_s;
      ASSERT_NEAR(even.layers.moving(x, y), all.layers.moving(x, y), 1e-6) << x << " " << y << " " << dt_s;
    }
  }
}

// Beyond the capacity, moving mass is spread evenly.
TEST(MovingBlocks, AreBounded) {
  constexpr int wide{280};
  Cpu cpu{2};
  FilterRun run{cpu, FilterConfig{}, {0, 0, 0.2, wide, wide}};
  ASSERT_GT(run.now.blocks.layout().count(), moving_blocks_max);
  std::mt19937 generator{5};
  std::uniform_real_distribution<float> share{0.05f, 0.95f};
  for (int step{0}; step < 4; ++step) {
    Image<float> observed{wide, wide};
    for (float& p : observed) p = share(generator);
    run.step(observed);
  }
  EXPECT_EQ(blocks_with_masses(run.now), moving_blocks_max);
  for (const float p : run.layers.occupancy) ASSERT_TRUE(p >= 0 && p <= 1) << p;
}

TEST(MovingBlocks, StateWithForeignSlotsIsRefused) {
  FilterState state{40, FilterConfig{}};
  state.blocks.want(1);
  allocate_marked_blocks(FilterTables{FilterConfig{}}, state);
  StateWriter writer;
  writer(state.blocks);
  FilterState read{40, FilterConfig{}};
  StateReader reader{writer.bytes()};
  reader(read.blocks);
  EXPECT_TRUE(reader.fits());
  EXPECT_EQ(read.blocks.slot(1), 0);

  std::vector<std::byte> damaged{writer.bytes()};
  const int slot{77};
  std::memcpy(damaged.data() + sizeof(std::size_t), &slot, sizeof(slot));
  StateReader of_damaged{damaged};
  of_damaged(read.blocks);
  EXPECT_FALSE(of_damaged.fits());
}

}  // namespace
}  // namespace stereogrid::test
