// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "fill/fill.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::messages {
namespace {

constexpr float no_disparity{-1};        // below min_disparity, which is 0
constexpr float disparity_step{0.0625};  // resolution of the matches

// values of PointField::datatype
constexpr std::uint8_t uint8{2};
constexpr std::uint8_t float32{7};

struct Field {
  const char* name;
  std::uint32_t offset;
  std::uint8_t datatype;
};
constexpr std::array<Field, 4> point_fields{
    {{"x", 0, float32}, {"y", 4, float32}, {"z", 8, float32}, {"label", 12, uint8}}};
constexpr std::size_t point_bytes{16};

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

void fill(stereo_msgs::DisparityImage& message, const StageImages& stages, const Rig& level_rig) {
  const Image<float>& obstacle{stages.obstacle_disparity};
  const Image<float>& road{stages.road_disparity};
  if (obstacle.width() != level_rig.width_px || obstacle.height() != level_rig.height_px ||
      road.size() != obstacle.size()) {
    throw InputError{"frame result", "its disparities do not have the rig's size.",
                     "Call FrameMessages::set_rig(result.rig)."};
  }
  sensor_msgs::Image& image{message.image};
  image.header = message.header;
  image.width = static_cast<std::uint32_t>(obstacle.width());
  image.height = static_cast<std::uint32_t>(obstacle.height());
  image.encoding = "32FC1";
  image.step = image.width * sizeof(float);
  image.data.resize(obstacle.size() * sizeof(float));
  std::byte* to{reinterpret_cast<std::byte*>(image.data.data())};
  float largest{0};
  for (std::size_t i{0}; i < obstacle.size(); ++i) {
    const float found{std::max(obstacle.data()[i], road.data()[i])};  // no pixel has both
    const float disparity{found > 0 ? found : no_disparity};
    largest = std::max(largest, disparity);
    std::memcpy(to + i * sizeof(float), &disparity, sizeof(float));
  }
  message.f = static_cast<float>(level_rig.focal_px);
  message.t = static_cast<float>(level_rig.baseline_m);
  message.valid_window = {0, 0, image.height, image.width, false};
  message.min_disparity = 0;
  // stages have a row of the u-disparity plane for each disparity that could be found
  message.max_disparity = std::max(static_cast<float>(stages.possible.size()), largest);
  message.delta_d = disparity_step;
}

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

void fill(sensor_msgs::PointCloud2& message, std::span<const LabelledPoint> points, std::optional<PointLabel> label) {
  const auto is_wanted = [&](const LabelledPoint& point) { return !label || point.label == *label; };
  message.height = 1;
  message.width = static_cast<std::uint32_t>(std::ranges::count_if(points, is_wanted));
  message.fields.resize(point_fields.size());
  for (std::size_t i{0}; i < point_fields.size(); ++i) {
    message.fields[i].name = point_fields[i].name;
    message.fields[i].offset = point_fields[i].offset;
    message.fields[i].datatype = point_fields[i].datatype;
    message.fields[i].count = 1;
  }
  message.point_step = point_bytes;
  message.row_step = message.width * message.point_step;
  message.is_dense = true;
  message.data.resize(message.row_step);
  std::uint8_t* to{message.data.data()};
  for (const LabelledPoint& point : points) {
    if (!is_wanted(point)) continue;
    const std::array<float, 3> place{point.x_m, point.y_m, point.z_m};
    std::memcpy(to, place.data(), sizeof(place));
    to[12] = static_cast<std::uint8_t>(point.label);
    to += point_bytes;
  }
}

void fill(sensor_msgs::CameraInfo& message, const Rig& rig) {
  const double f{rig.focal_px};
  const double u{rig.cx_px};
  const double v{rig.cy_px};
  message.height = static_cast<std::uint32_t>(rig.height_px);
  message.width = static_cast<std::uint32_t>(rig.width_px);
  message.distortion_model = "plumb_bob";
  message.d.assign(5, 0);
  message.k = {f, 0, u, 0, f, v, 0, 0, 1};
  message.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  message.p = {f, 0, u, 0, 0, f, v, 0, 0, 0, 1, 0};
}

void fill(sensor_msgs::CompressedImage& message, std::span<const std::byte> jpeg) {
  message.format = "jpeg";
  message.data.resize(jpeg.size());
  std::memcpy(message.data.data(), jpeg.data(), jpeg.size());
}

}  // namespace stereogrid::messages
