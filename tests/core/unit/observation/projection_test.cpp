// SPDX-License-Identifier: Apache-2.0
#include "observation/projection/projection.hpp"

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

// f·b = 100 px·m: bin d lies at x = 100/d m.
Rig round_rig() {
  return {201, 100, 400, 100, 50, 0.25, 1.5, 0, 0};
}

constexpr int disparities{30};

GridInVehicle placed(const GridGeometry& grid, const Pose2& vehicle_from_grid = {}) {
  return grid_in_vehicle(grid, vehicle_from_grid);
}

Image<float> projected(const Image<float>& occupancy, const GridInVehicle& grid) {
  Cpu cpu{1};
  Image<float> cells{grid.grid.nx, grid.grid.ny, -7.0f};
  ProjectionWorkspace space{occupancy.width(), occupancy.height()};
  project(cpu, occupancy.view(), BinGeometry{round_rig()}, grid, space, cells.view());
  return cells;
}

// Which cells does the footprint of bin (u, d) share an area with? Found by walking over the footprint, independent
// of the code's clipping.
Image<float> walked(int u, int d, const GridGeometry& grid, const Pose2& vehicle_from_grid) {
  constexpr int steps{900};
  const Rig rig{round_rig()};
  const Pose2 grid_from_vehicle{inverse(vehicle_from_grid)};
  Image<float> cells{grid.nx, grid.ny, 0.1f};
  for (int i{0}; i < steps; ++i) {
    const double disparity{d - 0.5 + (i + 0.5) / steps};
    const double x{rig.focal_px * rig.baseline_m / disparity};
    for (int j{0}; j < steps; ++j) {
      const double column{u - 0.5 + (j + 0.5) / steps};
      const double y{-(column - rig.cx_px) * rig.baseline_m / disparity};
      const Point2 at{grid_from_vehicle * Point2{x, y}};
      const int ix{static_cast<int>(std::floor((at.x - grid.x_min_m) / grid.cell_size_m))};
      const int iy{static_cast<int>(std::floor((at.y - grid.y_min_m) / grid.cell_size_m))};
      if (ix >= 0 && ix < grid.nx && iy >= 0 && iy < grid.ny) cells(ix, iy) = 0.9f;
    }
  }
  return cells;
}

struct Bin {
  int u;
  int d;
};

TEST(Projection, ABinAppearsInTheCellsThatItsFootprintTouches) {
  const GridGeometry grid{2, -6, 0.2, 90, 60};
  const GridGeometry around_the_car{-10, -10, 0.2, 100, 100};
  // grids that lie in the vehicle frame as they are, shifted, turned
  for (const auto& [geometry, pose] : {std::pair{grid, Pose2{}}, std::pair{grid, Pose2{1.13, -0.37, 0.4}},
                                       std::pair{around_the_car, Pose2{11.05, 1.31, 2.3}}}) {
    for (const Bin bin : {Bin{140, 10}, Bin{60, 10}, Bin{100, 25}, Bin{10, 20}, Bin{130, 7}}) {
      Image<float> occupancy{201, disparities, 0.1f};
      occupancy(bin.u, bin.d) = 0.9f;
      const Image<float> cells{projected(occupancy, placed(geometry, pose))};
      const Image<float> expected{walked(bin.u, bin.d, geometry, pose)};
      int found{0};
      for (const auto [ix, iy] : raster(geometry.nx, geometry.ny)) {
        EXPECT_EQ(cells(ix, iy) == 0.9f, expected(ix, iy) == 0.9f)
            << "bin " << bin.u << " " << bin.d << ", yaw " << pose.yaw_rad << ", cell " << ix << " " << iy;
        found += cells(ix, iy) == 0.9f ? 1 : 0;
      }
      EXPECT_GT(found, 0) << "bin " << bin.u << " " << bin.d << ", yaw " << pose.yaw_rad;
    }
  }
}

float at(const Image<float>& cells, const GridGeometry& grid, double x, double y) {
  return cells(static_cast<int>(std::floor((x - grid.x_min_m) / grid.cell_size_m)),
               static_cast<int>(std::floor((y - grid.y_min_m) / grid.cell_size_m)));
}

TEST(Projection, LeftOfTheImageIsLeftOfTheCar) {
  const GridGeometry grid{0, -10, 0.2, 100, 100};
  Image<float> occupancy{201, disparities, 0.1f};
  occupancy(60, 10) = 0.9f;  // 40 px left of the centre: y = +40·0.25/10 = 1 m, x = 10 m
  const Image<float> cells{projected(occupancy, placed(grid))};
  EXPECT_EQ(std::max({at(cells, grid, 9.9, 0.9), at(cells, grid, 10.1, 0.9), at(cells, grid, 9.9, 1.1),
                      at(cells, grid, 10.1, 1.1)}),
            0.9f);
  for (double x{9}; x < 11; x += 0.2) EXPECT_NE(at(cells, grid, x, -1.0), 0.9f);
}

TEST(Projection, CellsThatNoBinReachesAreUnknown) {
  const GridGeometry grid{-2, -10, 0.2, 120, 100};
  const Image<float> occupancy{201, disparities, 0.1f};
  const Image<float> cells{projected(occupancy, placed(grid))};
  EXPECT_EQ(at(cells, grid, -1, 0.1), 0.5f);    // behind the camera
  EXPECT_EQ(at(cells, grid, 3.1, 0.1), 0.5f);   // nearer than the largest disparity, 100/29.5 = 3.39 m
  EXPECT_EQ(at(cells, grid, 10.1, 3.1), 0.5f);  // the image ends at y = ±100.5/400·x
  EXPECT_EQ(at(cells, grid, 10.1, -3.1), 0.5f);
  EXPECT_EQ(at(cells, grid, 3.7, 0.1), 0.1f);
  EXPECT_EQ(at(cells, grid, 10.1, 2.1), 0.1f);
  EXPECT_EQ(at(cells, grid, 10.1, -2.1), 0.1f);
  EXPECT_EQ(at(cells, grid, 21.9, 0.1), 0.1f);
}

TEST(Projection, TheLargestOfSeveralBinsCounts) {
  const GridGeometry grid{3.9, -0.1, 0.2, 1, 1};  // x 3.9 … 4.1: bins 24 to 26; eight columns a side
  Image<float> occupancy{201, disparities, 0.02f};
  occupancy(100, 25) = 0.6f;
  EXPECT_EQ(projected(occupancy, placed(grid))(0, 0), 0.6f);
  occupancy(104, 24) = 0.8f;
  EXPECT_EQ(projected(occupancy, placed(grid))(0, 0), 0.8f);
  occupancy(150, 25) = 0.95f;  // beside the cell
  EXPECT_EQ(projected(occupancy, placed(grid))(0, 0), 0.8f);
}

Image<float> random_plane(int width, int bins, std::mt19937& generator) {
  Image<float> occupancy{width, bins, 0.5f};
  for (float& p : occupancy) p = static_cast<float>(uniform(generator, 0, 1));
  return occupancy;
}

TEST(ProjectionEquality, CpuEqualsReference) {
  std::mt19937 generator{53};
  Reference reference;
  for (int round{0}; round < 40; ++round) {
    const int width{uniform_int(generator, 1, 90)};
    const int bins{uniform_int(generator, 2, 40)};
    const Rig rig{width,
                  60,
                  uniform(generator, 40, 300),
                  uniform(generator, -5, width + 5.0),
                  30,
                  uniform(generator, 0.1, 0.6),
                  1.5,
                  0,
                  0};
    const Image<float> occupancy{random_plane(width, bins, generator)};
    const GridGeometry geometry{uniform(generator, -5, 5), uniform(generator, -10, 0), uniform(generator, 0.1, 0.7),
                                uniform_int(generator, 1, 40), uniform_int(generator, 1, 40)};
    const Pose2 pose{round == 0 ? Pose2{}
                                : Pose2{uniform(generator, -3, 6), uniform(generator, -3, 3),
                                        round % 4 == 0 ? 0.0 : uniform(generator, -3.1, 3.1)}};
    Cpu cpu{1 + round % 2};
    ProjectionWorkspace space{width, bins};
    Image<float> slow{geometry.nx, geometry.ny, -7.0f};
    Image<float> fast{geometry.nx, geometry.ny, -8.0f};
    project(reference, occupancy.view(), BinGeometry{rig}, placed(geometry, pose), space, slow.view());
    if (round % 3 == 0) space.plan(BinGeometry{rig}, placed(geometry, pose));
    project(cpu, occupancy.view(), BinGeometry{rig}, placed(geometry, pose), space, fast.view());
    EXPECT_EQ(count_differences(slow, fast), 0) << "round " << round;
  }
}

// The grid of a pipeline, whose cells begin at the camera itself, on round numbers.
TEST(ProjectionEquality, CpuEqualsReferenceOnTheVehicleGrid) {
  std::mt19937 generator{57};
  Reference reference;
  Cpu cpu{2};
  const GridGeometry geometry{0, -10, 0.2, 100, 100};
  const Image<float> occupancy{random_plane(201, disparities, generator)};
  ProjectionWorkspace space{201, disparities};
  Image<float> slow{geometry.nx, geometry.ny};
  Image<float> fast{slow};
  project(reference, occupancy.view(), BinGeometry{round_rig()}, placed(geometry), space, slow.view());
  for (const bool planned : {false, true}) {
    if (planned) space.plan(BinGeometry{round_rig()}, placed(geometry));
    std::fill(fast.begin(), fast.end(), -8.0f);
    project(cpu, occupancy.view(), BinGeometry{round_rig()}, placed(geometry), space, fast.view());
    EXPECT_EQ(count_differences(slow, fast), 0) << planned;
  }
}

// The window of a pipeline, in all headings, also nearly along the axes; another grid is planned.
TEST(ProjectionEquality, CpuEqualsReferenceInEveryHeading) {
  std::mt19937 generator{59};
  Reference reference;
  Cpu cpu{2};
  const GridGeometry geometry{-15, -15, 0.5, 60, 60};
  const Image<float> occupancy{random_plane(201, disparities, generator)};
  ProjectionWorkspace space{201, disparities};
  space.plan(BinGeometry{round_rig()}, placed(geometry));
  for (const double yaw : {1e-12, 1e-5, -2e-3, 0.01, 0.3, 0.7853981633974483, 1.5707963267948966, 1.57, -2.4, 3.1}) {
    const GridInVehicle grid{placed(geometry, {0.25, -0.1, yaw})};
    Image<float> slow{geometry.nx, geometry.ny};
    Image<float> fast{slow};
    project(reference, occupancy.view(), BinGeometry{round_rig()}, grid, space, slow.view());
    project(cpu, occupancy.view(), BinGeometry{round_rig()}, grid, space, fast.view());
    EXPECT_EQ(count_differences(slow, fast), 0) << "yaw " << yaw;
  }
}

}  // namespace
}  // namespace stereogrid::test
