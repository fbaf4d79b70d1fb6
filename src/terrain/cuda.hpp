// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "backend/cuda.hpp"
#include "stereogrid/camera.hpp"
#include "terrain/low_obstacles_model.hpp"
#include "terrain/relief.hpp"
#include "terrain/rules.hpp"
#include "terrain/samples.hpp"
#include "terrain/trenches.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// Data of the ground's walk on the device. Allocated once.
struct TerrainOnDevice {
  /// `rings`: see Rings::capacity. An empty rig: without terrain.
  TerrainOnDevice(Cuda& cuda, const Rig& level_rig, int window_px, const Rings& rings);

  /// The frame's ground after find_walk(), when the device has finished it.
  [[nodiscard]] WalkedGround<Host> on_host() {
    const View<const PolarCell, Device>& cells_there{walked.cells};
    return {{host_cells.data(), cells_there.width, cells_there.height, cells_there.pitch},
            {host_walks.data(), cells_there.height, 1, cells_there.height},
            host_sigma_px.data()};
  }

  int window_px;
  DeviceImage<float> medians;  ///< (row, sector), px
  DeviceBuffer<TrenchShape> shapes;
  DeviceBuffer<std::optional<Trench>> trenches;  ///< by sector
  DeviceBuffer<float> borders_m;                 ///< see RingTable
  DeviceBuffer<std::int16_t> ring_at;
  DeviceImage<float> x;  ///< see SampleTable
  DeviceImage<float> z;
  DeviceImage<std::int16_t> next;
  DeviceImage<std::int16_t> first;
  DeviceImage<RingSpread> spread;
  DeviceImage<bool> upright;
  DeviceBuffer<SectorRows> rows;
  DeviceBuffer<float> sigma_px;     ///< by ring
  DeviceBuffer<int> checked_rings;  ///< see checked_rings_of()
  DeviceBuffer<PolarCell> cells;    ///< rings of the frame only
  DeviceBuffer<SectorWalk> walks;

  // the same in pinned memory
  PinnedBuffer<float> host_borders_m;
  PinnedBuffer<std::int16_t> host_ring_at;
  PinnedBuffer<float> host_sigma_px;
  PinnedBuffer<PolarCell> host_cells;
  PinnedBuffer<SectorWalk> host_walks;

  // data of a frame
  WalkFrame frame;              ///< rings on the device
  WalkedGround<Device> walked;  ///< by find_walk()
};

/// Medians of all sectors in all rows, as on the CPU.
void find_medians(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                  TerrainOnDevice& terrain);

/// Begins a frame, as SectorWalks::begin() after the medians: places and noise of the samples, to host_sigma_px.
void begin_walk(Cuda& cuda, const WalkFrame& frame, TerrainOnDevice& terrain);

/// Trenches in the medians of the frame, as TrenchFilter on the CPU.
void find_trenches(Cuda& cuda, const SampledGround& ground, TerrainOnDevice& terrain);

/// Ground of the frame, as SectorWalks::find() after the trenches: on the device, and to host_cells and host_walks.
void find_walk(Cuda& cuda, TerrainOnDevice& terrain);

/// Applies rules, row by row without gaps, to `cells`. `rules` is on the device, or in pinned memory.
void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells);

/// Grids that are bounded, on the device, row by row without gaps. `witness` may be in pinned memory.
struct BoundedGrids {
  const float* age_s;  ///< ages in the vehicle's grid
  float* observed;
  float* occupancy;
  CellWitness* witness;
  const float* window_age_s;
  float* window_occupancy;
};

/// bound_cell() and bounded() for all cells. `bounds` may be in pinned memory.
void bound_grids(Cuda& cuda, const GridBounds<Device>& bounds, const BoundedGrids& grids);

/// Cells first_x … end_x − 1, first_y … end_y − 1 of a window, numbered row by row.
struct LowBox {
  int first_x;
  int first_y;
  int end_x;
  int end_y;

  [[nodiscard]] STEREOGRID_HD int size() const { return (end_x - first_x) * (end_y - first_y); }
  [[nodiscard]] STEREOGRID_HD bool has(int ix, int iy) const {
    return ix >= first_x && ix < end_x && iy >= first_y && iy < end_y;
  }
  [[nodiscard]] STEREOGRID_HD int index(int ix, int iy) const {
    return (iy - first_y) * (end_x - first_x) + ix - first_x;
  }
  [[nodiscard]] STEREOGRID_HD int ix(int cell) const { return first_x + cell % (end_x - first_x); }
  [[nodiscard]] STEREOGRID_HD int iy(int cell) const { return first_y + cell / (end_x - first_x); }
};

/// Input of a frame's low obstacles.
struct LowFrameOnDevice {
  LowModel model;
  LowBox box;  ///< has all samples
};

/// Levels of a cell's samples.
struct LowLevel {
  float middle_m;  ///< median; NaN: no samples
  float top_m;     ///< upper decile
  float noise_m;
};

/// Data of the cells of the box.
struct LowCellsOnDevice {
  int* counts;           ///< number of samples
  int* ends;             ///< place behind the last sample
  std::int16_t* sorted;  ///< samples by cell, 1/4096 m
  LowLevel* levels;
  LowWeight<int>* weights;
  LowRowMoments<long long>* moments;
  LowPlane* planes;
  LowSeen* seen;
};

/// Low obstacles of a frame in any order, in memory that the device reads.
struct LowFound {
  const int* count;
  const LowCell* cells;
};

/// Finds low obstacles on the device. Equal to LowObstacleFinder to the bit, in any order.
class LowObstaclesOnDevice {
 public:
  LowObstaclesOnDevice(const Rig& level_rig, int window_cells, int disparities);

  /// Sets the frame of further searches. `noise_px`: see Terrain::noise_px().
  void put(const LowModel& model, std::span<const float> noise_px);
  /// Enqueues the search. `obstacle`, `road`: (H, W) px, 0 = none.
  void find(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road);
  [[nodiscard]] LowFound on_device() const { return {sums_.data() + 1, cells_.data()}; }
  /// Cells of the last find(), when the device has finished it.
  [[nodiscard]] std::span<const LowCell> found() { return {cells_.data(), cells_.data() + *found_.data()}; }

 private:
  int width_px_;
  int height_px_;
  PinnedBuffer<LowFrameOnDevice> frame_;
  DeviceBuffer<LowFrameOnDevice> frame_on_device_;
  PinnedBuffer<float> noise_px_;
  DeviceBuffer<float> noise_on_device_;
  DeviceBuffer<int> counts_;
  DeviceBuffer<int> ends_;
  DeviceBuffer<std::int16_t> sorted_;
  DeviceBuffer<LowLevel> levels_;
  DeviceBuffer<LowWeight<int>> weights_;
  DeviceBuffer<LowRowMoments<long long>> moments_;
  DeviceBuffer<LowPlane> planes_;
  DeviceBuffer<LowSeen> seen_;
  DeviceBuffer<int> sums_;  ///< samples placed, cells written
  PinnedBuffer<int> found_;
  PinnedBuffer<LowCell> cells_;  ///< written from the device: they are few, and how many changes
};

/// Finds relief and cells of a frame's ground on the device. Equal to TerrainRelief and Terrain::visit() to the bit,
/// the cells in any order.
class GroundOnDevice {
 public:
  /// `rings`: most of them; 0: nothing.
  GroundOnDevice(const Rig& level_rig, int rings, const GridGeometry& vehicle_grid, int window_cells);

  /// Sets the frame of further searches. `rings`, `walked`: the same on the device.
  void put(const GroundFrame<Host>& frame, const RingTable& rings, const WalkedGround<Device>& walked);
  /// Enqueues the search. `relief`: (bin, sector), see Relief; `low`: low obstacles on the device.
  void find(Cuda& cuda, LowFound low, View<std::int16_t, Device> relief);
  /// Rules of the last find(), with its low obstacles.
  [[nodiscard]] const CellRule* vehicle_rules() const { return rules_[0].data(); }
  [[nodiscard]] const CellRule* window_rules() const { return rules_[1].data(); }
  /// Cells with ground of the last find(), when the device has finished it.
  [[nodiscard]] std::span<const GroundCell> found() { return {cells_.data(), cells_.data() + *found_.data()}; }

 private:
  int sectors_;
  PinnedBuffer<GroundFrame<Device>> frame_;
  DeviceBuffer<GroundFrame<Device>> frame_on_device_;
  PinnedBuffer<float> by_ring_;  ///< noise of elevations, noise of the plane
  DeviceBuffer<float> by_ring_on_device_;
  DeviceImage<float> elevations_;               ///< (ring, sector)
  std::array<DeviceImage<CellRule>, 2> rules_;  ///< rules of the vehicle's grid and the window
  DeviceBuffer<int> found_on_device_;
  PinnedBuffer<int> found_;
  PinnedBuffer<GroundCell> cells_;  ///< written from the device: how many changes
};

}  // namespace stereogrid
