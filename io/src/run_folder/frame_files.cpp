// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/frame_files.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "stereogrid/io/npz.hpp"

namespace stereogrid::io {
namespace {

using Layers = std::vector<std::reference_wrapper<const Image<float>>>;

/// Several grids as one array (n, ny, nx).
struct Stack {
  explicit Stack(const Layers& layers) {
    const Image<float>& first{layers.front()};
    shape = {layers.size(), static_cast<std::size_t>(first.height()), static_cast<std::size_t>(first.width())};
    for (const Image<float>& layer : layers) values.insert(values.end(), layer.begin(), layer.end());
  }
  [[nodiscard]] NpzArray named(const char* name) const { return {name, shape, values}; }

  std::vector<std::size_t> shape;
  std::vector<float> values;
};

/// Several grids as one array of halves, (ny, nx) or (n, ny, nx). Steps whose numbers end in zeros pack well.
struct CompactStack {
  CompactStack(const Layers& layers, float steps_per_unit) {
    const Image<float>& first{layers.front()};
    shape = {static_cast<std::size_t>(first.height()), static_cast<std::size_t>(first.width())};
    if (layers.size() > 1) shape.insert(shape.begin(), layers.size());
    for (const Image<float>& layer : layers) {
      for (const float value : layer) values.emplace_back(std::round(value * steps_per_unit) / steps_per_unit);
    }
  }
  [[nodiscard]] NpzArray named(const char* name) const { return {name, shape, values}; }

  std::vector<std::size_t> shape;
  std::vector<Half> values;
};

}  // namespace

void write_compact_grids(const std::filesystem::path& path, const FrameResult& result) {
  constexpr float of_one{256};
  constexpr float of_mps{16};
  constexpr float of_second{64};
  const CompactStack observed{Layers{result.observed}, of_one};
  const CompactStack occupancy{Layers{result.vehicle.occupancy}, of_one};
  const CompactStack moving{Layers{result.vehicle.moving}, of_one};
  const CompactStack age_s{Layers{result.vehicle.age_s}, of_second};
  const CompactStack velocity{Layers{result.vehicle.velocity_x, result.vehicle.velocity_y}, of_mps};
  const std::array<NpzArray, 5> arrays{observed.named("observed"), occupancy.named("occupancy"), moving.named("moving"),
                                       age_s.named("age_s"), velocity.named("velocity")};
  write_npz(path, arrays);
}

void write_grids(const std::filesystem::path& path, const FrameResult& result) {
  const GridLayers& world{result.world};
  const Stack velocity{Layers{result.vehicle.velocity_x, result.vehicle.velocity_y}};
  const Stack covariance{Layers{result.vehicle.velocity_xx, result.vehicle.velocity_xy, result.vehicle.velocity_yy}};
  const Stack world_velocity{Layers{world.velocity_x, world.velocity_y}};
  const Stack world_covariance{Layers{world.velocity_xx, world.velocity_xy, world.velocity_yy}};
  const std::vector<double> origin{world.geometry.x_min_m, world.geometry.y_min_m};
  const std::array<NpzArray, 12> arrays{
      NpzArray{"observed", result.observed},
      NpzArray{"occupancy", result.vehicle.occupancy},
      NpzArray{"moving", result.vehicle.moving},
      NpzArray{"age_s", result.vehicle.age_s},
      velocity.named("velocity"),
      covariance.named("velocity_covariance"),
      NpzArray{"world_occupancy", world.occupancy},
      NpzArray{"world_moving", world.moving},
      NpzArray{"world_age_s", world.age_s},
      world_velocity.named("world_velocity"),
      world_covariance.named("world_velocity_covariance"),
      NpzArray{"world_origin", {2}, origin},
  };
  write_npz(path, arrays);
}

void write_predictions(const std::filesystem::path& path, const FrameResult& result) {
  std::vector<double> horizons_s;
  Layers vehicle;
  Layers world;
  for (const Prediction& prediction : result.predictions) {
    horizons_s.push_back(prediction.horizon_s);
    vehicle.emplace_back(prediction.occupancy);
    world.emplace_back(prediction.world_occupancy);
  }
  const Stack occupancy{vehicle};
  const Stack world_occupancy{world};
  const std::vector<double> origin{result.world.geometry.x_min_m, result.world.geometry.y_min_m};
  const std::array<NpzArray, 4> arrays{
      NpzArray{"horizon_s", {horizons_s.size()}, horizons_s},
      occupancy.named("occupancy"),
      world_occupancy.named("world_occupancy"),
      NpzArray{"world_origin", {2}, origin},
  };
  write_npz(path, arrays);
}

void write_stages(const std::filesystem::path& path, const StageImages& stages) {
  const std::array<NpzArray, 11> arrays{
      NpzArray{"obstacle_disparity", stages.obstacle_disparity},
      NpzArray{"road_disparity", stages.road_disparity},
      NpzArray{"match_confidence", stages.match_confidence},
      NpzArray{"possible", {stages.possible.size()}, stages.possible},
      NpzArray{"visible", stages.visible},
      NpzArray{"observed_pixels", stages.observed},
      NpzArray{"visibility", stages.visibility},
      NpzArray{"obstacle_confidence", stages.obstacle_confidence},
      NpzArray{"road_confidence", stages.road_confidence},
      NpzArray{"u_occupancy", stages.occupancy},
      NpzArray{"u_occupancy_smooth", stages.occupancy_smooth},
  };
  write_npz(path, arrays);
}

}  // namespace stereogrid::io
