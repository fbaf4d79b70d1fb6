// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "memory_bytes.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/result.hpp"
#include "terrain/elevation_memory.hpp"
#include "terrain/ground_witness.hpp"
#include "terrain/low_obstacles.hpp"
#include "terrain/rules.hpp"
#include "terrain/terrain.hpp"

namespace stereogrid {

/// Place and time of a frame's terrain.
struct TerrainPlace {
  GridGeometry window;         ///< the filter's grid, world axes
  GridInVehicle window_cells;  ///< the window in the vehicle frame
  Pose2 world_from_vehicle;
  double dt_s;
  GridInVehicle vehicle_in_camera;  ///< the vehicle's grid in the frame of the camera
  GridInVehicle window_in_camera;
};

/// Bounds the grids of a result, see bound_cell().
void bound_grids(const GridBounds<Host>& bounds, FrameResult& result);

/// Terrain of a camera's frame in its two grids: the vehicle's grid and the window of the filter. That of one camera
/// keeps what all cameras have seen.
class FrameTerrain {
 public:
  FrameTerrain(const Rig& level_rig, const Config& config, const GridGeometry& vehicle_grid, int window_cells);

  /// Begins a frame: what earlier ones have left moves with the window.
  void move(const TerrainPlace& place);
  /// After move(), where the camera has an image: before set_noise() and find(), see Terrain.
  void begin(const Ground& ground, const Ground& surface) {
    is_measured_ = ground.estimated || !estimates_ground_;
    terrain_.begin(ground, surface);
  }
  [[nodiscard]] WalkFrame walk_frame() const { return terrain_.walk_frame(); }
  /// Sets the noise of the frame's samples, see Stages::begin_walk().
  void set_noise(const float* sigma_px) { terrain_.set_noise(sigma_px); }
  /// After set_noise(): what the search for low obstacles needs.
  const LowModel& begin_low_obstacles() {
    return low_obstacles_.begin(terrain_.camera(), place_.window_in_camera, terrain_.checked_m());
  }
  [[nodiscard]] std::span<const float> noise_px() const { return terrain_.noise_px(); }
  /// Sets the ground of the frame's walk, valid until the next begin(), and its edges.
  void set_walked(const WalkedGround<Host>& walked) {
    terrain_.set_walked(walked);
    edges_.clear();
    terrain_.add_edges(edges_);
  }
  /// Input of find_ground() elsewhere, after set_noise(). Its cells are not set.
  [[nodiscard]] GroundFrame<Host> ground_frame() const {
    return terrain_.ground_frame(place_.vehicle_in_camera, place_.window_in_camera,
                                 {vehicle_grid_, place_.window_cells});
  }
  /// Finds relief and cells of the ground after set_walked(): sets elevation and classes of `result`.
  template <class ForRanges>
  void find_ground(const ForRanges& for_ranges, FrameResult& result) {
    terrain_.find_relief(for_ranges);
    for_ranges(vehicle_grid_.ny, [&](int begin, int end) {
      clear_vehicle(begin, end, result);
      terrain_.visit(place_.vehicle_in_camera, begin, end,
                     [&](int ix, int iy, const CellGround& ground) { write_vehicle(ix, iy, ground, result); });
    });
    for_ranges(place_.window.ny, [&](int begin, int end) {
      clear_window(begin, end);
      terrain_.visit(place_.window_in_camera, begin, end,
                     [&](int ix, int iy, const CellGround& ground) { write_window(ix, iy, ground); });
    });
  }
  /// Sets the cells, as find_ground() has found them elsewhere, in any order.
  void set_ground(std::span<const GroundCell> cells, FrameResult& result);
  /// Marks low obstacles of the frame, after its ground. `low`: cells of LowObstacleFinder, valid until the next frame.
  void mark_low_obstacles(std::span<const LowCell> low, FrameResult& result);
  /// A frame in which the camera has no image.
  void find_nothing(const TerrainPlace& place);

  /// Edges of the last find(), from left to right.
  [[nodiscard]] std::span<const EdgePoint> edges() const { return edges_; }
  /// Cells of sure low obstacles after the last find_bounds(), by rows. The caller may sort them.
  [[nodiscard]] std::span<LowObstacleCell> low_cells() { return low_cells_; }
  /// Bounds of the filtered occupancy but for bars: where the last find() has seen nothing behind an edge, and where
  /// cells below ½ have no witness; edges and low obstacles that it has seen, edges that a frame before has seen and
  /// none since ground, and low obstacles that several have seen. Sets the witnesses of free cells, see bound_cell().
  /// `seen`: terrains whose last find() counts, of this camera and others; empty: none.
  /// `claims_free`: whether another source has seen a place of the vehicle frame as free; empty: there is none.
  template <class ForRanges>
  void find_bounds(std::span<const FrameTerrain* const> seen, const std::function<bool(Point2)>& claims_free,
                   const ForRanges& for_ranges, FrameResult& result) {
    if (!seen.empty()) {
      merge(seen);
      for_ranges(place_.window.ny, [&](int begin, int end) {
        drop_witnesses(begin, end);
        drop_unconfirmed(seen, begin, end);
      });
    }
    bound_cells(seen, claims_free, result);
  }
  /// After find_bounds(): adds bars that several frames have seen. `filtered`: occupancy of the window without bounds.
  /// Returns the bounds, valid until the next find_bounds().
  GridBounds<Host> add_bars(std::span<const FrameTerrain* const> seen, View<const float> filtered);
  /// Adds the elevations of the frame, and sets those over time. May run beside both.
  void remember_elevation(std::span<const FrameTerrain* const> seen, FrameResult& result);
  /// When the grids are final: sets the classes over time.
  void classify(FrameResult& result) const;
  /// Sets the speed limit of the camera by its last find(). `is_usable`: the frame has one that counts; else
  /// `since_s` has passed since the frame before: infinite if that does not count any more.
  void limit_speed(bool is_usable, double since_s, FrameResult& result);
  /// Clears the hazards of frames before.
  void reset() {
    age_s_ = std::numeric_limits<double>::infinity();
    low_obstacles_.reset();
    witness_.reset();
    elevation_.reset();
  }
  /// Marks all cells of `result` as unseen.
  static void clear(FrameResult& result);
  /// Rules of the last find().
  [[nodiscard]] TerrainRules rules() const { return {terrain_.relief(), vehicle_rules_.view(), window_rules_.view()}; }
  template <class State>
  void exchange(State& state) {
    state(window_x_m_, window_y_m_, age_s_, low_obstacles_, witness_, elevation_);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(terrain_, low_obstacles_, witness_, elevation_, edges_, low_cells_, vehicle_rules_,
                           window_rules_, vehicle_bounds_, window_bounds_);
  }

 private:
  void clear_vehicle(int begin, int end, FrameResult& result);
  void write_vehicle(int ix, int iy, const CellGround& ground, FrameResult& result);
  void clear_window(int begin, int end);
  void write_window(int ix, int iy, const CellGround& ground);
  void merge(std::span<const FrameTerrain* const> seen);
  void drop_witnesses(int begin, int end);
  void drop_unconfirmed(std::span<const FrameTerrain* const> seen, int begin, int end);
  void bound_cells(std::span<const FrameTerrain* const> seen, const std::function<bool(Point2)>& claims_free,
                   FrameResult& result);
  [[nodiscard]] float distance_to(int ix, int iy) const;
  [[nodiscard]] auto hazard();
  void add_hazards(std::span<const FrameTerrain* const> seen);
  void see_ground(std::span<const FrameTerrain* const> seen);
  void see_claims(bool is_usable, const std::function<bool(Point2)>& claims_free);
  void find_witnesses(bool is_usable, const std::function<bool(Point2)>& claims_free, FrameResult& result) const;

  bool estimates_ground_;
  bool is_measured_{false};  ///< the last frame's plane, or as good as that
  GridGeometry vehicle_grid_;
  VehicleConfig vehicle_;
  Terrain terrain_;
  LowObstacles low_obstacles_;
  GroundWitness witness_;
  ElevationMemory elevation_;
  TerrainPlace place_{};  ///< place of the last find()
  std::vector<EdgePoint> edges_;
  std::vector<LowObstacleCell> low_cells_;
  Image<CellRule> vehicle_rules_;
  Image<CellRule> window_rules_;
  Image<std::uint8_t> vehicle_bounds_;
  Image<std::uint8_t> window_bounds_;
  double window_x_m_{0};  ///< origin of the window
  double window_y_m_{0};
  double age_s_{std::numeric_limits<double>::infinity()};  ///< time since the camera's last usable frame
};

}  // namespace stereogrid
