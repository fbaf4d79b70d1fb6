// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "frame_files.hpp"

#include <array>
#include <span>
#include <vector>

#include "stereogrid/io/npz.hpp"

namespace stereogrid::app {
namespace {

/// Two grids as one array (2, ny, nx).
std::vector<float> stacked(const Image<float>& x, const Image<float>& y) {
  std::vector<float> both(x.begin(), x.end());
  both.insert(both.end(), y.begin(), y.end());
  return both;
}

std::vector<std::size_t> shape_of_pair(const Image<float>& layer) {
  return {2, static_cast<std::size_t>(layer.height()), static_cast<std::size_t>(layer.width())};
}

}  // namespace

void write_grids(const std::filesystem::path& path, const FrameResult& result) {
  const GridLayers& world{result.world};
  const std::vector<float> velocity{stacked(result.velocity_x, result.velocity_y)};
  const std::vector<float> world_velocity{stacked(world.velocity_x, world.velocity_y)};
  const std::vector<double> origin{world.geometry.x_min_m, world.geometry.y_min_m};
  const std::array<io::NpzArray, 8> arrays{
      io::NpzArray{"observed", result.observed},
      io::NpzArray{"occupancy", result.occupancy},
      io::NpzArray{"age_s", result.age_s},
      io::NpzArray{"velocity", shape_of_pair(result.velocity_x), velocity},
      io::NpzArray{"world_occupancy", world.occupancy},
      io::NpzArray{"world_velocity", shape_of_pair(world.velocity_x), world_velocity},
      io::NpzArray{"world_age_s", world.age_s},
      io::NpzArray{"world_origin", {2}, origin},
  };
  io::write_npz(path, arrays);
}

void write_stages(const std::filesystem::path& path, const StageImages& stages) {
  const std::array<io::NpzArray, 11> arrays{
      io::NpzArray{"obstacle_disparity", stages.obstacle_disparity},
      io::NpzArray{"road_disparity", stages.road_disparity},
      io::NpzArray{"match_confidence", stages.match_confidence},
      io::NpzArray{"possible", {stages.possible.size()}, stages.possible},
      io::NpzArray{"visible", stages.visible},
      io::NpzArray{"observed_pixels", stages.observed},
      io::NpzArray{"visibility", stages.visibility},
      io::NpzArray{"obstacle_confidence", stages.obstacle_confidence},
      io::NpzArray{"road_confidence", stages.road_confidence},
      io::NpzArray{"u_occupancy", stages.occupancy},
      io::NpzArray{"u_occupancy_smooth", stages.occupancy_smooth},
  };
  io::write_npz(path, arrays);
}

}  // namespace stereogrid::app
