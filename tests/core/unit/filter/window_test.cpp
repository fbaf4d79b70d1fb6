// SPDX-License-Identifier: Apache-2.0
#include "filter/filter.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr float never{std::numeric_limits<float>::infinity()};

TEST(VelocityLattice, IsASquareWithStandstillInTheMiddle) {
  FilterConfig config;
  config.speeds_mps = {2, 4.5};
  const std::vector<Point2> lattice{velocity_lattice(config)};
  ASSERT_EQ(lattice.size(), 25u);
  EXPECT_EQ(lattice[12].x, 0);
  EXPECT_EQ(lattice[12].y, 0);
  // y-major
  EXPECT_EQ(lattice[13].x, 2);
  EXPECT_EQ(lattice[13].y, 0);
  EXPECT_EQ(lattice[17].x, 0);
  EXPECT_EQ(lattice[17].y, 2);
  EXPECT_EQ(lattice[0].x, -4.5);
  EXPECT_EQ(lattice[0].y, -4.5);
  const FilterTables tables{config};
  ASSERT_EQ(tables.axis_mps.size(), 5u);
  EXPECT_FLOAT_EQ(tables.axis_mps[4], 4.5f);
  config.speeds_mps.clear();
  EXPECT_EQ(velocity_lattice(config).size(), 1u);
}

TEST(Window, CoversTheVehicleGridInEveryHeading) {
  for (const GridGeometry& grid : {GridGeometry{0, -10, 0.2, 100, 100}, GridGeometry{0, -3, 0.25, 70, 24}}) {
    const Window window{grid};
    for (int i{0}; i < 200; ++i) {
      const Pose2 pose{0.137 * i - 9, 3.3 - 0.071 * i, 0.1 * i};
      const GridGeometry placed{window.at(pose)};
      EXPECT_EQ(placed.nx, window.cells());
      EXPECT_EQ(placed.ny, window.cells());
      for (const int iy : {0, grid.ny}) {
        for (const int ix : {0, grid.nx}) {
          const Point2 corner{pose *
                              Point2{grid.x_min_m + ix * grid.cell_size_m, grid.y_min_m + iy * grid.cell_size_m}};
          const double x{(corner.x - placed.x_min_m) / placed.cell_size_m};
          const double y{(corner.y - placed.y_min_m) / placed.cell_size_m};
          // interpolation needs a neighbour on every side
          EXPECT_GE(std::min(x, y), 0.5) << i;
          EXPECT_LE(std::max(x, y), window.cells() - 0.5) << i;
        }
      }
    }
  }
}

TEST(Window, MovesInWholeCells) {
  const Window window{{0, -10, 0.2, 100, 100}};
  for (int i{0}; i < 100; ++i) {
    const GridGeometry placed{window.at({0.0731 * i, -0.031 * i, 0.02 * i})};
    EXPECT_NEAR(std::remainder(placed.x_min_m, 0.2), 0, 1e-9);
    EXPECT_NEAR(std::remainder(placed.y_min_m, 0.2), 0, 1e-9);
    EXPECT_EQ(placed.cell_size_m, 0.2);
  }
  // the grid reaches 20 m ahead, so its middle lies 10 m ahead of the car
  const GridGeometry ahead{window.at({0, 0, 0})};
  EXPECT_NEAR(ahead.x_min_m + 0.1 * ahead.nx, 10, 0.2);
  EXPECT_NEAR(ahead.y_min_m + 0.1 * ahead.ny, 0, 0.2);
  const GridGeometry turned{window.at({0, 0, 90 * degree})};
  EXPECT_NEAR(turned.x_min_m + 0.1 * turned.nx, 0, 0.2);
  EXPECT_NEAR(turned.y_min_m + 0.1 * turned.ny, 10, 0.2);
}

GridLayers layers_of(const GridGeometry& geometry) {
  GridLayers layers{grid_layers(geometry)};
  layers.occupancy.fill(0.5f);
  layers.age_s.fill(never);
  return layers;
}

FrameResult resampled(const GridLayers& world, const Pose2& world_from_vehicle, const GridGeometry& grid) {
  const Image<float> cells{grid.nx, grid.ny, -7};
  FrameResult result{};
  result.world = world;
  result.vehicle = {grid, cells, cells, cells, cells, cells, cells, cells, cells};
  resample(world_from_vehicle, result);
  return result;
}

TEST(Resample, PutsCellsWhereARotatedCarSeesThem) {
  GridLayers world{layers_of({-4, -4, 0.2, 40, 40})};
  // a block of 3 × 3 cells around (1.1, 2.1), which moves in +x
  for (const auto [ix, iy] : raster(24, 27, 29, 32)) {
    world.occupancy(ix, iy) = 0.9f;
    world.velocity_x(ix, iy) = 3;
    world.velocity_xx(ix, iy) = 4;
    world.velocity_xy(ix, iy) = 0.5f;
    world.velocity_yy(ix, iy) = 1;
    world.moving(ix, iy) = 0.6f;
    world.age_s(ix, iy) = 0.25f;
  }
  // the car at (1.1, −0.9) faces +y: the block's middle is 3 m ahead; +x is to its right
  const GridGeometry grid{0, -2, 0.2, 24, 20};
  const FrameResult seen{resampled(world, {1.1, -0.9, 90 * degree}, grid)};
  const auto cell_at = [&](const Image<float>& image, double x, double y) {
    return image(static_cast<int>((x - grid.x_min_m) / 0.2), static_cast<int>((y - grid.y_min_m) / 0.2));
  };
  EXPECT_NEAR(cell_at(seen.vehicle.occupancy, 3.1, 0.1), 0.9, 1e-5);
  EXPECT_NEAR(cell_at(seen.vehicle.velocity_x, 3.1, 0.1), 0, 1e-5);
  EXPECT_NEAR(cell_at(seen.vehicle.velocity_y, 3.1, 0.1), -3, 1e-5);
  EXPECT_NEAR(cell_at(seen.vehicle.velocity_xx, 3.1, 0.1), 1, 1e-5);
  EXPECT_NEAR(cell_at(seen.vehicle.velocity_xy, 3.1, 0.1), -0.5, 1e-5);
  EXPECT_NEAR(cell_at(seen.vehicle.velocity_yy, 3.1, 0.1), 4, 1e-5);
  EXPECT_NEAR(cell_at(seen.vehicle.moving, 3.1, 0.1), 0.6, 1e-5);
  EXPECT_FLOAT_EQ(cell_at(seen.vehicle.age_s, 3.1, 0.1), 0.25f);
  for (const Point2 elsewhere : {Point2{3.7, 0.1}, Point2{2.3, 0.1}, Point2{3.1, 0.7}, Point2{3.1, -0.7}}) {
    EXPECT_NEAR(cell_at(seen.vehicle.occupancy, elsewhere.x, elsewhere.y), 0.5, 1e-5);
    EXPECT_EQ(cell_at(seen.vehicle.age_s, elsewhere.x, elsewhere.y), never);
  }
}

// Half a cell off, cells beside an observed one have a part of it: its age, too. Beside dynamic mass in unobserved
// cells they are no more likely than the motion.
TEST(Resample, CellsKnownFromObservedOnesBesideThemHaveTheirAge) {
  GridLayers world{layers_of({-4, -4, 0.2, 40, 40})};
  world.occupancy(24, 20) = 0.9f;
  world.age_s(24, 20) = 0.25f;
  world.occupancy(30, 20) = 0.9f;
  world.moving(30, 20) = 0.9f;
  const Pose2 pose{0.09, 0, 0};
  FrameResult result{resampled(world, pose, {0, -0.4, 0.2, 14, 4})};
  complete_unobserved(pose, result);
  const auto column = [&](const Image<float>& layer) { return std::vector<float>(&layer(0, 2), &layer(0, 2) + 14); };
  const std::vector<float> ages{column(result.vehicle.age_s)};
  const std::vector<float> occupancies{column(result.vehicle.occupancy)};
  EXPECT_EQ(std::ranges::count(ages, 0.25f), 2);
  EXPECT_FLOAT_EQ(ages[3], 0.25f);
  EXPECT_NEAR(occupancies[3], 0.5 + 0.4 * 0.45, 1e-4);
  EXPECT_NEAR(occupancies[9], 0.5, 1e-4) << "0.45 of 0.9 moves there";
  EXPECT_NEAR(occupancies[10], 0.5, 1e-4) << "0.55 of 0.9";
  EXPECT_EQ(ages[10], never);
}

// By 30°: the covariance turns as R C Rᵀ.
TEST(Resample, TurnsTheCovariance) {
  GridLayers world{layers_of({-4, -4, 0.2, 40, 40})};
  world.velocity_xx.fill(3);
  world.velocity_xy.fill(0.4f);
  world.velocity_yy.fill(1);
  const FrameResult seen{resampled(world, {0, 0, 30 * degree}, {0.1, 0.1, 0.2, 2, 2})};
  const double c{std::cos(30 * degree)};
  const double s{std::sin(30 * degree)};
  EXPECT_NEAR(seen.vehicle.velocity_xx(1, 1), c * c * 3 + 2 * c * s * 0.4 + s * s, 1e-5);
  EXPECT_NEAR(seen.vehicle.velocity_xy(1, 1), -c * s * 3 + (c * c - s * s) * 0.4 + c * s, 1e-5);
  EXPECT_NEAR(seen.vehicle.velocity_yy(1, 1), s * s * 3 - 2 * c * s * 0.4 + c * c, 1e-5);
}

TEST(Resample, OfAnAlignedGridIsACopy) {
  std::mt19937 generator{3};
  GridLayers world{layers_of({-1, -2, 0.2, 20, 20})};
  for (float& p : world.occupancy) p = static_cast<float>(uniform(generator, 0, 1));
  const GridGeometry grid{0, 0, 0.2, 5, 6};
  const FrameResult seen{resampled(world, {0.6, -0.4, 0}, grid)};
  for (const auto [ix, iy] : raster(grid.nx, grid.ny))
    EXPECT_NEAR(seen.vehicle.occupancy(ix, iy), world.occupancy(ix + 8, iy + 8), 1e-5);
}

TEST(Resample, InterpolatesOccupancyBetweenCells) {
  GridLayers world{layers_of({0, 0, 0.2, 10, 10})};
  for (const auto [x, y] : raster(10, 10)) world.occupancy(x, y) = static_cast<float>(0.05 * x + 0.03 * y);
  // a quarter of a cell to the right, half a cell up
  const FrameResult seen{resampled(world, {0.05, 0.1, 0}, {0.4, 0.4, 0.2, 3, 3})};
  EXPECT_NEAR(seen.vehicle.occupancy(0, 0), 0.05 * 2.25 + 0.03 * 2.5, 1e-5);
  EXPECT_NEAR(seen.vehicle.occupancy(2, 1), 0.05 * 4.25 + 0.03 * 3.5, 1e-5);
}

TEST(Resample, OutsideTheWindowNothingIsKnown) {
  GridLayers world{layers_of({0, 0, 0.2, 10, 10})};
  world.occupancy.fill(0.9f);
  world.velocity_x.fill(1);
  world.velocity_y.fill(1);
  world.age_s.fill(0);
  const FrameResult seen{resampled(world, {0, 0, 0}, {-1, 0.4, 0.2, 20, 3})};
  for (const int ix : {0, 3, 16, 19}) {
    EXPECT_EQ(seen.vehicle.occupancy(ix, 1), 0.5f) << ix;
    EXPECT_EQ(seen.vehicle.velocity_x(ix, 1), 0) << ix;
    EXPECT_EQ(seen.vehicle.velocity_y(ix, 1), 0) << ix;
    EXPECT_EQ(seen.vehicle.age_s(ix, 1), never) << ix;
  }
  EXPECT_NEAR(seen.vehicle.occupancy(8, 1), 0.9, 1e-6);
}

}  // namespace
}  // namespace stereogrid::test
