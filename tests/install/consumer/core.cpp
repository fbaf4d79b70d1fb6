// SPDX-License-Identifier: Apache-2.0
//
// A textured wall 4 m ahead, made without any other library, has to come out as occupied cells 4 m ahead. Exceptions of
// the library have to be caught here. With the argument "cuda": started with an emulated libstereogrid_cuda.so that
// finds no GPU; an exception of that library crosses the core's border, too.
#include <stereogrid/error.hpp>
#include <stereogrid/level_mapping.hpp>
#include <stereogrid/pipeline.hpp>
#include <stereogrid/pixel_view.hpp>
#include <stereogrid/points.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace {

constexpr int disparity_px{20};

stereogrid::Rig small_rig() {
  return {
      .width_px = 200, .height_px = 120, .focal_px = 160, .cx_px = 100, .cy_px = 60, .baseline_m = 0.5};  // f·b/d = 4 m
}

stereogrid::StereoFrame wall(const stereogrid::Rig& rig) {
  stereogrid::StereoFrame frame;
  std::vector<std::uint8_t> camera_memory(static_cast<std::size_t>(rig.width_px) * rig.height_px);
  std::mt19937 random{1};
  for (std::uint8_t& grey : camera_memory) grey = static_cast<std::uint8_t>(random() % 256);
  stereogrid::assign(frame.left, {camera_memory.data(), rig.width_px, rig.height_px});
  frame.right = stereogrid::Image<std::uint8_t>{rig.width_px, rig.height_px};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u + disparity_px < rig.width_px; ++u) frame.right(u, v) = frame.left(u + disparity_px, v);
  }
  return frame;
}

bool is_refused(const stereogrid::Rig& rig) {
  try {
    const stereogrid::Pipeline pipeline{stereogrid::preset("default"), rig};
  } catch (const stereogrid::ConfigError&) {
    return true;
  }
  return false;
}

int find_no_gpu() {
  try {
    const stereogrid::Pipeline pipeline{
        stereogrid::preset("default"), small_rig(), {.back_end = stereogrid::BackEnd::cuda}};
  } catch (const stereogrid::DeviceError& error) {
    std::printf("%s\n", error.what());
    return std::string{error.what()}.find("No NVIDIA GPU was found") != std::string::npos ? 0 : 1;
  }
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view{argv[1]} == "cuda") return find_no_gpu();
  const stereogrid::Rig rig{small_rig()};
  stereogrid::Pipeline pipeline{stereogrid::preset("default"), rig, {.threads = 2}};
  const stereogrid::FrameResult& result{pipeline.process(wall(rig))};

  const stereogrid::GridGeometry& grid{result.vehicle.geometry};
  const int ix{static_cast<int>((4.0 - grid.x_min_m) / grid.cell_size_m)};
  const int iy{static_cast<int>((0.0 - grid.y_min_m) / grid.cell_size_m)};
  const float at_wall{result.observed(ix, iy)};
  const bool has_points{!stereogrid::points_of(result, result.level_rig).empty()};
  const bool is_level{stereogrid::LevelMapping{rig}.is_identity()};
  std::printf("stereogrid %s: P(occupied) at the wall %.3f\n", stereogrid::version().data(), at_wall);
  return std::isfinite(at_wall) && at_wall > 0.75f && has_points && is_level && is_refused(stereogrid::Rig{}) ? 0 : 1;
}
