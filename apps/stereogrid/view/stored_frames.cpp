// SPDX-License-Identifier: Apache-2.0
#include "view/playback.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "input.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;
using Arrays = std::map<std::string, io::NpyArray>;

/// Layer of an array in the cells of a grid; missing, or of another size: `otherwise` everywhere.
Image<float> layer_of(const Arrays& arrays, const std::string& name, int layer, const GridGeometry& grid,
                      float otherwise) {
  Image<float> image{grid.nx, grid.ny};
  const auto found{arrays.find(name)};
  const std::size_t skipped{image.size() * static_cast<std::size_t>(layer)};
  if (found == arrays.end() || found->second.size() < skipped + image.size()) {
    std::ranges::fill(image, otherwise);
    return image;
  }
  const std::vector<float> cells{found->second.to<float>()};
  std::copy_n(cells.begin() + static_cast<std::ptrdiff_t>(skipped), image.size(), image.begin());
  return image;
}

// Runs of older versions have none: 0.
template <class Byte>
Image<Byte> bytes_of(const Arrays& arrays, const std::string& name, const GridGeometry& grid) {
  const Image<float> numbers{layer_of(arrays, name, 0, grid, 0)};
  Image<Byte> bytes{grid.nx, grid.ny};
  std::ranges::transform(numbers, bytes.begin(), [](float number) { return Byte{static_cast<std::uint8_t>(number)}; });
  return bytes;
}

GridLayers layers_of(const Arrays& arrays, const std::string& prefix, const GridGeometry& grid) {
  constexpr float unknown{0.5F};
  constexpr float never_s{std::numeric_limits<float>::infinity()};
  return {.geometry = grid,
          .occupancy = layer_of(arrays, prefix + "occupancy", 0, grid, unknown),
          .velocity_x = layer_of(arrays, prefix + "velocity", 0, grid, 0),
          .velocity_y = layer_of(arrays, prefix + "velocity", 1, grid, 0),
          .age_s = layer_of(arrays, prefix + "age_s", 0, grid, arrays.contains(prefix + "age_s") ? never_s : 0),
          .moving = layer_of(arrays, prefix + "moving", 0, grid, 0)};
}

/// Cells of the vehicle grid where the world has them, in a window that holds the whole vehicle grid.
GridLayers sampled(const GridLayers& vehicle, const Pose2& world_from_vehicle) {
  const GridGeometry& from{vehicle.geometry};
  double x_min_m{std::numeric_limits<double>::infinity()};
  double y_min_m{x_min_m};
  double x_max_m{-x_min_m};
  double y_max_m{-x_min_m};
  for (const Point2 corner : {from.centre(0, 0), from.centre(from.nx - 1, 0), from.centre(0, from.ny - 1),
                              from.centre(from.nx - 1, from.ny - 1)}) {
    const Point2 there{world_from_vehicle * corner};
    x_min_m = std::min(x_min_m, there.x);
    y_min_m = std::min(y_min_m, there.y);
    x_max_m = std::max(x_max_m, there.x);
    y_max_m = std::max(y_max_m, there.y);
  }
  const double size_m{from.cell_size_m};
  const GridGeometry to{std::floor(x_min_m / size_m) * size_m, std::floor(y_min_m / size_m) * size_m, size_m,
                        static_cast<int>((x_max_m - x_min_m) / size_m) + 2,
                        static_cast<int>((y_max_m - y_min_m) / size_m) + 2};
  GridLayers world{layers_of({}, "", to)};
  std::ranges::fill(world.age_s, std::numeric_limits<float>::infinity());
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  const Pose2 turn{0, 0, world_from_vehicle.yaw_rad};
  for (int iy{0}; iy < to.ny; ++iy) {
    for (int ix{0}; ix < to.nx; ++ix) {
      const auto cell{from.cell_at(vehicle_from_world * to.centre(ix, iy))};
      if (!cell) continue;
      const Point2 velocity{turn *
                            Point2{vehicle.velocity_x(cell->ix, cell->iy), vehicle.velocity_y(cell->ix, cell->iy)}};
      world.occupancy(ix, iy) = vehicle.occupancy(cell->ix, cell->iy);
      world.velocity_x(ix, iy) = static_cast<float>(velocity.x);
      world.velocity_y(ix, iy) = static_cast<float>(velocity.y);
      world.age_s(ix, iy) = vehicle.age_s(cell->ix, cell->iy);
      world.moving(ix, iy) = vehicle.moving(cell->ix, cell->iy);
    }
  }
  return world;
}

/// Input of a run; none: it is not there any more.
std::optional<Input> input_of(const io::RunInput& from) {
  try {
    return open_input({.paths = from.paths,
                       .calibration = from.calibration,
                       .poses = from.kind == "scene" ? "" : "none",
                       .disparities = from.disparities,
                       .cameras = from.cameras});
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const DeviceError&) {
    return std::nullopt;
  }
}

class StoredFrames final : public PlayedFrames {
 public:
  explicit StoredFrames(const fs::path& folder) : run_{folder}, input_{input_of(run_.input())} {
    for (const io::RunFrame& frame : run_.frames()) {
      const auto stamp_ns{static_cast<std::uint64_t>(std::max<std::int64_t>(frame.stamp_ns, 0))};
      stamps_ns_.push_back(stamps_ns_.empty() ? stamp_ns : std::max(stamp_ns, stamps_ns_.back()));
    }
  }

  [[nodiscard]] const std::vector<std::uint64_t>& stamps_ns() const override { return stamps_ns_; }

  void send(std::size_t frame, messages::Sink& sink) override {
    const io::RunFrame& stored{run_.frames().at(frame)};
    const FrameResult result{stored_result(run_, stored)};
    // velocities are those between neighbours: after a jump there is none
    if (!messages_ || frame != next_) messages_.emplace(sink, result.rig);
    next_ = frame + 1;
    messages_->set_rig(result.rig);
    const std::optional<StereoFrame> loaded{frame_of_input(stored)};
    std::vector<std::uint8_t> jpeg;
    messages::FrameFacts facts{.stamp_ns = static_cast<std::int64_t>(stamps_ns_.at(frame)),
                               .frames = static_cast<std::int64_t>(frame + 1)};
    if (loaded) {
      facts.left_jpeg = [&](int camera) {
        const StereoFrame* const seen{stereogrid::frame_of(*loaded, camera)};
        jpeg = seen == nullptr ? std::vector<std::uint8_t>{} : left_jpeg(seen->left);
        return std::as_bytes(std::span{jpeg});
      };
    }
    messages_->send(result, facts);
  }

 private:
  /// The frame in the input; none: unavailable.
  [[nodiscard]] std::optional<StereoFrame> frame_of_input(const io::RunFrame& frame) const {
    if (!input_ || frame.index >= input_->source->size() || input_->source->name(frame.index) != frame.name) return {};
    try {
      return input_->source->load(frame.index);
    } catch (const InputError&) {
      return {};
    } catch (const DeviceError&) {
      return {};
    }
  }

  static std::vector<std::uint8_t> left_jpeg(const Image<std::uint8_t>& left) {
    constexpr int quality{80};
    if (left.empty()) return {};
    return io::encode_jpeg({left.data(), left.width(), left.height()}, quality);
  }

  io::RunReader run_;
  std::optional<Input> input_;
  std::vector<std::uint64_t> stamps_ns_;
  std::optional<messages::FrameMessages> messages_;
  std::size_t next_{0};
};

}  // namespace

FrameResult stored_result(const io::RunReader& run, const io::RunFrame& frame) {
  const fs::path file{run.folder() / "grids" / (frame.name + ".npz")};
  const Arrays arrays(io::read_npz(file));
  FrameResult result;
  result.rig = run.rig_of(frame);
  result.level_rig = result.rig;
  result.world_from_vehicle = frame.world_from_vehicle;
  result.vehicle = layers_of(arrays, "", run.grid());
  if (!arrays.contains("occupancy"))
    result.vehicle.occupancy = run.occupancy(frame.name);  // throws: names the missing layer
  result.observed = layer_of(arrays, "observed", 0, run.grid(), 0.5F);
  if (arrays.contains("elevation_m") && arrays.contains("elevation_sigma_m")) {
    result.elevation_m = layer_of(arrays, "elevation_m", 0, run.grid(), 0);
    result.elevation_sigma_m = layer_of(arrays, "elevation_sigma_m", 0, run.grid(), 0);
    result.witness = bytes_of<CellWitness>(arrays, "witness", run.grid());
  }
  if (arrays.contains("world_occupancy")) {
    result.world = layers_of(arrays, "world_", run.world_grid(frame.name).geometry);
    if (arrays.contains("world_elevation_m") && arrays.contains("world_elevation_sigma_m")) {
      const GridGeometry& grid{result.world.geometry};
      result.world_elevation_m = layer_of(arrays, "world_elevation_m", 0, grid, 0);
      result.world_elevation_sigma_m = layer_of(arrays, "world_elevation_sigma_m", 0, grid, 0);
      result.world_terrain = bytes_of<TerrainClass>(arrays, "world_terrain", grid);
    }
  } else {
    result.world = sampled(result.vehicle, result.world_from_vehicle);
  }
  for (const std::string& name : run.camera_names()) {
    FrameResult& camera{result.cameras.emplace_back()};
    camera.camera_name = name;
    camera.rig = camera.level_rig = run.rigs_of(frame).at(result.cameras.size() - 1);
  }
  result.obstacles = frame.obstacles;
  result.timing_ms = frame.timing_ms;
  result.status = frame.status;
  result.speed_limit_mps = frame.speed_limit_mps;
  result.speed_limit_reason = frame.speed_limit_reason;
  return result;
}

std::unique_ptr<PlayedFrames> stored_frames(const fs::path& folder) {
  return std::make_unique<StoredFrames>(folder);
}

}  // namespace stereogrid::app
