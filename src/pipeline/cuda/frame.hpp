// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "filter/cuda.hpp"
#include "fusion/cuda.hpp"
#include "ground/cuda.hpp"
#include "images/row_alignment/cuda.hpp"
#include "matching/cuda.hpp"
#include "projection/cuda.hpp"
#include "rays/cuda.hpp"
#include "stereogrid/result.hpp"
#include "u_disparity/cuda.hpp"

namespace stereogrid {

/// What is different in every frame and kernels read. Uploaded at the frame's start, so that the graphs need not be
/// recorded again.
struct FrameOnDevice {
  RoadPlane plane;  ///< of the road, before it is measured
  Ground expected;  ///< the same, for given disparities
  GroundPrior prior;
  RowShift rows;
  GridInVehicle vehicle_cells;     ///< the vehicle's grid in the vehicle frame
  GridInVehicle window_cells;      ///< the window in the vehicle frame
  GridInVehicle vehicle_in_world;  ///< the vehicle's grid in the world
  GridGeometry window;
  FilterMotion motion;
};

/// What the host must know of a frame before anything else.
struct FrameFromDevice {
  Ground ground;
  int is_lost;
  int matched[2];  ///< pixels: obstacle, road
};

/// The grids that a frame leaves, one after the other, so that one copy brings them all to the host: the observed grid,
/// the layers of the world's window, those of the vehicle's grid.
struct PackedGrids {
  PackedGrids(const GridGeometry& vehicle_grid, int window_cells);

  [[nodiscard]] std::size_t size() const { return vehicle_cells * (1 + layers) + world_cells * layers; }
  void copy_to(const float* packed, FrameResult& result) const;

  static constexpr int layers{8};
  std::size_t vehicle_cells;
  std::size_t world_cells;
};

/// What a frame brings to the device and takes from it, in pinned host memory.
struct HostMemory {
  HostMemory(const Rig& rig, const GridGeometry& vehicle_grid, int window_cells);

  PinnedBuffer<FrameOnDevice> frame;
  PinnedBuffer<FrameFromDevice> answer;
  PinnedBuffer<std::uint8_t> left;
  PinnedBuffer<std::uint8_t> right;
  PinnedBuffer<float> given;                ///< disparities
  PinnedBuffer<float> lattice;              ///< see gather_lattice
  PinnedBuffer<float> obstacle;             ///< disparities of obstacles
  PinnedBuffer<float> grids;                ///< see PackedGrids
  PinnedBuffer<VelocityEvidence> evidence;  ///< read from here: it is little, and how much changes
  PinnedBuffer<int> evidence_count;
};

/// What the stages hand to each other and keep between frames, on the device. Allocated once.
struct DeviceMemory {
  DeviceMemory(Cuda& cuda, const Config& config, const Rig& rig, const GridGeometry& vehicle_grid, int window_cells,
               const FilterTables& tables);

  void upload_frame(Cuda& cuda, const HostMemory& host, bool is_given);
  /// Counts what has matched, and downloads what the host waits for.
  void fetch_answer(Cuda& cuda, HostMemory& host);
  /// Both observed grids are unknown.
  void observe_nothing(Cuda& cuda);
  void fetch_grids(Cuda& cuda, HostMemory& host);
  /// Waits for them.
  void fetch_stages(Cuda& cuda, StageImages& stages) const;

  DeviceBuffer<FrameOnDevice> frame;
  DeviceBuffer<FrameFromDevice> answer;
  DeviceImage<std::uint8_t> left;
  DeviceImage<std::uint8_t> right;
  DeviceImage<std::uint8_t> aligned;
  DeviceImage<float> given;
  DeviceImage<float> lattice;
  DeviceImage<std::uint8_t> masked;  ///< PixelMask, where there is one
  DeviceMatches matches;
  MatchingSpaceOnDevice matching;
  GroundOnDevice ground;
  UDisparityOnDevice u_disparity;
  ProjectionOnDevice projection;
  RaysOnDevice rays;
  OtherGridsOnDevice other_grids;
  FilterOnDevice filter;
  std::array<FilterStateOnDevice, 2> states;
  DeviceImage<float> observed;
  DeviceImage<float> observed_window;
  LayersOnDevice world;
  LayersOnDevice vehicle;
  DeviceBuffer<float> grids;  ///< see PackedGrids
};

/// Marks on the stream, between which time is measured.
class StreamTimes {
 public:
  enum Mark { start, uploaded, matched, ground_known, counted, projected, filtered, fetched, answered };
  static constexpr int marks{9};

  StreamTimes();
  StreamTimes(const StreamTimes&) = delete;
  StreamTimes& operator=(const StreamTimes&) = delete;
  ~StreamTimes();
  /// Also within a graph, for the times of its launches.
  void mark(Cuda& cuda, Mark which);
  /// Of the last call of `mark` outside a graph.
  void wait_for(Mark which);
  /// Milliseconds in the last frame; both marks must have been reached.
  [[nodiscard]] double between(Mark from, Mark to) const;
  /// The upload belongs to match, the download to filter.
  [[nodiscard]] StageTimes stages() const;

 private:
  std::array<cudaEvent_t, marks> events_{};
};

}  // namespace stereogrid
