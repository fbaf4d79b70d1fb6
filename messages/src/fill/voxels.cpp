// SPDX-License-Identifier: Apache-2.0
#include "fill/fill.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace stereogrid::messages {
namespace {

constexpr std::uint64_t empty{~std::uint64_t{0}};
constexpr int axis_bits{20};
constexpr double axis_limit{1 << (axis_bits - 1)};

std::uint64_t coordinate(float value_m, double voxel_m) {
  const double voxel{std::floor(static_cast<double>(value_m) / voxel_m)};
  return static_cast<std::uint64_t>(std::clamp(voxel, -axis_limit, axis_limit - 1) + axis_limit);
}

std::uint64_t voxel_of(const LabelledPoint& point, double voxel_m) {
  std::uint64_t voxel{static_cast<std::uint64_t>(point.label)};
  for (const float value_m : {point.x_m, point.y_m, point.z_m}) {
    voxel = voxel << axis_bits | coordinate(value_m, voxel_m);
  }
  return voxel;
}

}  // namespace

void VoxelFilter::apply(std::vector<LabelledPoint>& points, const GridGeometry& grid, double voxel_m) {
  if (voxel_m == 0) return;
  std::erase_if(points, [&](const LabelledPoint& point) {
    return !grid.cell_at({static_cast<double>(point.x_m), static_cast<double>(point.y_m)});
  });
  keep_first_of_each(points, voxel_m);
  while (points.size() > points_max) keep_first_of_each(points, voxel_m *= 2);
}

void VoxelFilter::keep_first_of_each(std::vector<LabelledPoint>& points, double voxel_m) {
  constexpr std::uint64_t golden_ratio{0x9E3779B97F4A7C15};  // Fibonacci hashing
  const std::size_t size{std::bit_ceil(2 * points.size() + 2)};
  const int shift{64 - std::countr_zero(size)};
  voxels_.assign(size, empty);
  std::erase_if(points, [&](const LabelledPoint& point) {
    const std::uint64_t voxel{voxel_of(point, voxel_m)};
    auto place{static_cast<std::size_t>(voxel * golden_ratio >> shift)};
    while (voxels_[place] != empty && voxels_[place] != voxel) place = (place + 1) % size;
    const bool has_point{voxels_[place] == voxel};
    voxels_[place] = voxel;
    return has_point;
  });
}

}  // namespace stereogrid::messages
