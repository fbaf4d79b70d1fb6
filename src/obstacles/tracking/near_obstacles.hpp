// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fusion/model.hpp"
#include "geometry/road_plane.hpp"
#include "ground/frame_validator.hpp"
#include "memory_bytes.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Cells and obstacles that remain as they were observed last.
struct HeldObstacles {
  std::vector<RetainedCell> cells;  ///< without duplicates
  std::vector<std::int64_t> ids;    ///< ids of obstacles, ascending
};

/// Static obstacles near enough for the camera to lose them: beyond the disparity search, or in front of all ground in
/// view. They remain occupied until pixels match behind them. docs/method.md §11.3.
class NearObstacles {
 public:
  NearObstacles(const Rig& level_rig, const MatchingConfig& matching, int window_cells);

  /// Compares the obstacles with a frame's matches, before the grids are made. `road`: predicted plane.
  void compare(const MatchedFrame& frame, const Ground& road, const Pose2& world_from_vehicle,
               const GridGeometry& window);
  /// Result of compare(). In a reliable frame, only unmatchable obstacles are held.
  [[nodiscard]] const HeldObstacles& held(bool is_reliable) const { return is_reliable ? unmatchable_ : present_; }
  /// Replaces the cells of near obstacles observed in the frame. Reads world and obstacles of `result`, which `tracker`
  /// has reported.
  void update(const FrameResult& result, const Tracker& tracker, const Ground& road, const Pose2& world_from_vehicle,
              bool is_reliable);

  void clear() { cells_.clear(); }

  template <class State>
  void exchange(State& state) {
    state(cells_);
    if constexpr (requires { state.require(true); }) state.require(cells_.size() <= retained_cells_max);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(cells_, states_, columns_, is_taken_, unmatchable_.cells, unmatchable_.ids, present_.cells,
                           present_.ids);
  }

 private:
  /// Occupied cell of an obstacle.
  struct Cell {
    std::int64_t id;  ///< id of the obstacle
    int x;            ///< column and row of the world's grid, in cells from the world's origin
    int y;
    float occupancy;
    float height_m;  ///< height of the obstacle
  };
  /// State of a cell's obstacle. `present`: it fills the view; `unmatchable`: present, but impossible to match.
  enum class CellState : std::uint8_t { out_of_view, gone, in_view, present, unmatchable };
  /// Pixels of MatchLattice in a column that the obstacle would cover.
  struct Column {
    double near_m;  ///< distance of the obstacle; infinite: not in this column
    int pixels;
    int pixels_behind;  ///< pixels matched behind the obstacle
    int textured;
    int textured_behind;
    CellState state;
  };

  void clear_result();
  [[nodiscard]] Point2 centre(const Cell& cell, const Pose2& vehicle_from_world) const;
  [[nodiscard]] int column_at(Point2 place) const;
  void find_columns(std::span<const Cell> cells, const Pose2& vehicle_from_world);
  void count(const MatchedFrame& frame, const Ground& road, double height_m, double textured_grey);
  void decide_columns(const Ground& road, double height_m);
  [[nodiscard]] bool fills_view(const RowsByHeight& rows) const;
  [[nodiscard]] bool is_gone(int index) const;
  void decide_cells(std::span<const Cell> cells, std::span<CellState> states, const Pose2& vehicle_from_world);
  void hold(std::span<const Cell> cells, std::span<const CellState> states, const GridGeometry& window);
  [[nodiscard]] bool is_near(const Outline& outline, const Ground& road) const;
  void take_cells(const Obstacle& obstacle, const Outline& outline, const GridLayers& world,
                  const Pose2& world_from_vehicle);

  Rig rig_;
  MatchingConfig matching_;
  double cell_size_m_{0};
  std::vector<Cell> cells_;  // sorted by obstacle

  // data of one frame
  std::vector<CellState> states_;  // by cell of cells_
  std::vector<Column> columns_;    // by column of MatchLattice
  Image<std::uint8_t> is_taken_;   // by cell of the window: 1 for those in cells_
  HeldObstacles unmatchable_;
  HeldObstacles present_;
};

/// Adds FrameStatus::too_close and its warning where a held obstacle is not seen in the frame.
void report_too_close(const HeldObstacles& held, FrameResult& result);

}  // namespace stereogrid
