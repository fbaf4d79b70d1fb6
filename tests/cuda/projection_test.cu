// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include "backend/reference.hpp"
#include "check.hpp"
#include "fusion/cuda.hpp"
#include "fusion/fusion.hpp"
#include "images.hpp"
#include "observation/projection/cuda.hpp"

namespace stereogrid::test {
namespace {

void check_projection(const Rig& rig, const Image<float>& occupancy, const GridInVehicle& grid) {
  Cuda cuda;
  Reference reference;
  const BinGeometry bins{rig};
  const DeviceImage<float> plane{on_device(cuda, occupancy)};
  const DeviceBuffer<GridInVehicle> place{one_on_device(cuda, grid)};
  ProjectionWorkspace unused{occupancy.width(), occupancy.height()};
  Image<float> expected{grid.grid.nx, grid.grid.ny};
  project(reference, occupancy.view(), bins, grid, unused, expected.view());
  ProjectionOnDevice space{occupancy.width(), occupancy.height()};
  DeviceImage<float> cells{grid.grid.nx, grid.grid.ny};
  find_largest(cuda, plane.view(), space);
  project(cuda, plane.view(), bins, place.data(), space, cells.view());
  CHECK_EQUAL(differences(on_host(cuda, cells), expected), 0);
}

TEST(cells_are_those_of_the_reference) {
  Random random{21};
  for (int round{0}; round < 12; ++round) {
    const int width{random.whole(1, 90)};
    const Rig rig{width, 60, random.between(40, 300), random.between(-5, width + 5.0), 30, random.between(0.1, 0.6)};
    const GridGeometry grid{random.between(-5, 5), random.between(-10, 0), random.between(0.1, 0.7),
                            random.whole(1, 40), random.whole(1, 40)};
    const Pose2 pose{random.between(-3, 6), random.between(-3, 3), round % 3 == 0 ? 0.0 : random.between(-3.1, 3.1)};
    check_projection(rig, random.image(width, random.whole(2, 40), 0, 1), grid_in_vehicle(grid, pose));
  }
}

TEST(cells_in_special_headings) {
  Random random{23};
  const Rig rig{101, 60, 100, 50, 30, 0.5};
  const Image<float> occupancy{random.image(101, 30, 0, 1)};
  for (const double yaw : {0.0, 1e-12, 1e-5, -2e-3, 0.7853981633974483, 1.5707963267948966, 1.57, 3.1}) {
    check_projection(rig, occupancy, grid_in_vehicle({-6, -6, 0.5, 24, 25}, {0.25, -0.1, yaw}));
  }
}

TEST(other_grids_are_fused_as_by_the_reference) {
  Random random{25};
  const Image<float> stereo{random.image(83, 71, 0, 1)};
  const GridInVehicle grid{grid_in_vehicle({-4, -8, 0.2, 83, 71}, {1, -2, 0.3})};
  const std::vector<ObservedGrid> two{{{-3, -5, 0.3, 40, 50}, random.image(40, 50, 0, 1), random.image(40, 50, 0, 1)},
                                      {{2, 1, 0.11, 61, 33}, random.image(61, 33, 0, 1), {}}};
  Cuda cuda;
  Reference reference;
  const DeviceBuffer<GridInVehicle> place{one_on_device(cuda, grid)};
  OtherGridsOnDevice others;
  const FusionConfig config{0.9};
  for (const std::size_t count : {1u, 0u, 2u}) {
    const std::span<const ObservedGrid> given{two.data(), count};
    Image<float> expected{stereo};
    fuse(reference, given, grid, config, expected.view());
    others.take(cuda, given);
    DeviceImage<float> cells{on_device(cuda, stereo)};
    fuse(cuda, others, place.data(), config, cells.view());
    CHECK_EQUAL(differences(on_host(cuda, cells), expected), 0);
    CHECK_EQUAL(differences(expected, stereo) > 0, count > 0);
  }
}

}  // namespace
}  // namespace stereogrid::test
