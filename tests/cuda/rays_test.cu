// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "backend/reference.hpp"
#include "check.hpp"
#include "images.hpp"
#include "observation/rays/cuda.hpp"
#include "observation/rays/rays.hpp"

namespace stereogrid::test {
namespace {

TEST(rays_are_those_of_the_reference) {
  Random random{31};
  for (int round{0}; round < 8; ++round) {
    const int width{random.whole(1, 300)};
    const int height{random.whole(1, 70)};
    const int disparities{random.whole(2, 60)};
    const Rig rig{width, height, random.between(40, 300), width / 2.0, random.between(0, 40), random.between(0.1, 0.6)};
    const Ground ground{random.between(0.3, 3), random.between(-0.1, 0.1), random.between(-0.2, 0.2), true};
    Matches matches{width, height};
    for (int v{0}; v < height; ++v) {
      for (int u{0}; u < width; ++u) {
        const float d{static_cast<float>(random.between(0.1, disparities + 3.0))};
        if (random.happens(0.6)) matches.obstacle(u, v) = ambiguous_px;
        if (random.happens(0.3)) (random.happens(0.5) ? matches.road : matches.obstacle)(u, v) = d;
      }
    }
    UDisparityConfig config;
    config.follow_roll = round % 2 == 0;
    Reference reference;
    const bool has_relief{round % 3 == 0};
    RayWorkspace expected{width, height, disparities, has_relief};
    Image<std::int16_t> relief{2 * disparities, relief_sectors(width)};
    for (std::int16_t& rows : relief) rows = static_cast<std::int16_t>(random.between(-height, height));
    if (has_relief) expected.relief = {std::as_const(relief).view()};
    count_rays(reference, matches, rig, ground, config, expected);
    Cuda cuda;
    const DeviceImage<float> obstacle{on_device(cuda, matches.obstacle)};
    const DeviceImage<float> road{on_device(cuda, matches.road)};
    const DeviceBuffer<Ground> plane{one_on_device(cuda, ground)};
    RaysOnDevice space{width, height, disparities, has_relief};
    if (has_relief) upload(cuda, relief.data(), relief.size(), space.relief.data());
    for (int frame{0}; frame < 2; ++frame) {  // the second must not see the first
      count_rays(cuda, {obstacle.view(), road.view()}, rig, plane.data(), config, space);
    }
    std::vector<PackedRays> sums(space.sums.size());
    download(cuda, space.sums.data(), sums.size(), sums.data());
    cuda.synchronize();
    CHECK(std::equal(sums.begin(), sums.end(), expected.sums.begin(), expected.sums.end()));

    const GridInVehicle grid{grid_in_vehicle({random.between(-5, 5), -4, 0.3, 37, 29},
                                             {random.between(-3, 6), 1, random.between(-3.1, 3.1)})};
    const DeviceBuffer<GridInVehicle> place{one_on_device(cuda, grid)};
    expected.blur_px = static_cast<float>(random.between(0, 0.6));
    const DeviceBuffer<float> blur_px{one_on_device(cuda, expected.blur_px)};
    Image<float> cells{37, 29};
    project_rays(reference, expected, BinGeometry{rig}, grid, cells.view());
    DeviceImage<float> found{37, 29};
    project_rays(cuda, space, BinGeometry{rig}, place.data(), blur_px.data(), found.view());
    CHECK_EQUAL(differences(on_host(cuda, found), cells), 0);
  }
}

}  // namespace
}  // namespace stereogrid::test
