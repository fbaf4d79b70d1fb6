// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "filter/cuda.hpp"
#include "fusion/cuda.hpp"
#include "geometry/road_plane.hpp"
#include "images/row_alignment/cuda.hpp"
#include "matching/cuda.hpp"
#include "observation/projection/cuda.hpp"
#include "observation/rays/cuda.hpp"
#include "observation/u_disparity/cuda.hpp"
#include "stereogrid/result.hpp"
#include "terrain/cuda.hpp"

namespace stereogrid {

/// Input of kernels that changes in every frame of the camera. Uploaded at the frame's start, so that the graphs need
/// not be recorded again.
struct FrameOnDevice {
  RoadPlane plane;  ///< plane of the road hypothesis
  Ground ground;    ///< the same; plane under the observed grids
  RowShift rows;
  GridInVehicle seen_vehicle;  ///< the vehicle's grid in the frame of the camera
  GridInVehicle seen_window;   ///< likewise the window
};

/// Likewise of all cameras together: input of the filter and of grids of other sources.
struct FrameSetOnDevice {
  GridInVehicle vehicle_cells;     ///< the vehicle's grid in the vehicle frame
  GridInVehicle window_cells;      ///< the window in the vehicle frame
  GridInVehicle vehicle_in_world;  ///< the vehicle's grid in the world
  GridGeometry window;
  FilterMotion motion;
};

/// Pixels that have matched, of the part of the image that a warp counts.
struct MatchedPixels {
  int obstacle;
  int road;
};

/// Results that the host needs before all others.
struct FrameFromDevice {
  static constexpr int counting_warps{512};

  MatchedPixels matched[counting_warps];
};

/// Layout of the single upload and the single download: offset of each part, in bytes.
struct FrameLayout {
  explicit FrameLayout(const Rig& rig);

  // FrameOnDevice, and behind it both images, or external disparities
  std::size_t left;
  std::size_t right;
  std::size_t images_end;
  std::size_t given_end;
  // FrameFromDevice, and behind it the matches read by the host
  std::size_t lattice;  ///< see gather_lattice
  std::size_t answer_end;
};

/// Sizes of the grids; without a filter the filtered ones are empty.
struct GridSizes {
  GridSizes(const GridGeometry& vehicle_grid, bool filters);

  GridGeometry vehicle;
  int window;  ///< cells along a side
  GridGeometry filtered_vehicle;
  int filtered_window;
};

/// The grids that a frame leaves, one after the other, so that few copies bring them to the host: the observed grid,
/// the layers of the world's window, of which the occupancy is the first, those of the vehicle's grid.
struct PackedGrids {
  explicit PackedGrids(const GridSizes& sizes);

  static constexpr int window{2};  ///< first image of the window behind its occupancy
  static constexpr int window_end{1 + 8};
  static constexpr int images{1 + 2 * 8};
  /// Images begin … end − 1.
  static void copy_to(const float* packed, int begin, int end, FrameResult& result);

  std::size_t world;    ///< offset of the window's layers
  std::size_t vehicle;  ///< likewise of the vehicle's grid
  std::size_t size;
};

/// The T in a buffer of bytes.
template <class T, class Buffer>
T* at(Buffer& buffer, std::size_t offset) {
  return reinterpret_cast<T*>(buffer.data() + offset);
}

/// Upload and download of a frame, in pinned host memory.
struct HostMemory {
  HostMemory(const Rig& rig, const GridSizes& sizes, std::size_t relief_size);

  [[nodiscard]] FrameOnDevice& frame() { return *at<FrameOnDevice>(input, 0); }
  [[nodiscard]] std::uint8_t* left() { return at<std::uint8_t>(input, layout.left); }
  [[nodiscard]] std::uint8_t* right() { return at<std::uint8_t>(input, layout.right); }
  [[nodiscard]] float* given() { return at<float>(input, layout.left); }
  [[nodiscard]] FrameFromDevice& answer() { return *at<FrameFromDevice>(output, 0); }
  [[nodiscard]] const float* lattice() { return at<float>(output, layout.lattice); }

  FrameLayout layout;
  PinnedBuffer<std::byte> input;
  PinnedBuffer<std::byte> output;
  PinnedBuffer<FrameSetOnDevice> set;
  PinnedBuffer<float> grids;                  ///< see PackedGrids
  PinnedBuffer<std::uint8_t> vehicle_bounds;  ///< see GridBounds
  PinnedBuffer<std::uint8_t> window_bounds;
  PinnedBuffer<CellWitness> witness;
  PinnedBuffer<float> observed;             ///< the camera's own observed grid, beside that of all
  PinnedBuffer<VelocityEvidence> evidence;  ///< read from here: it is little, and how much changes
  PinnedBuffer<int> evidence_count;
  PinnedBuffer<RetainedCell> held;  ///< likewise
  PinnedBuffer<int> held_count;
  PinnedBuffer<float> blur_px;
  PinnedBuffer<std::int16_t> relief;
};

/// Data of the stages and between frames, on the device. Allocated once.
struct DeviceMemory {
  DeviceMemory(Cuda& cuda, const Config& config, const Rig& rig, const GridSizes& sizes, const FilterTables& tables);

  [[nodiscard]] FrameOnDevice* frame() { return at<FrameOnDevice>(input, 0); }
  [[nodiscard]] FrameFromDevice* answer() { return at<FrameFromDevice>(output, 0); }
  void upload_frame(Cuda& cuda, const HostMemory& host, bool is_external);
  /// Counts the matches, and downloads the results that the host waits for.
  void fetch_answer(Cuda& cuda, HostMemory& host);
  /// Both observed grids are unknown.
  void observe_nothing(Cuda& cuda);
  /// The window's occupancy, as the filter leaves it.
  void fetch_occupancy(Cuda& cuda, HostMemory& host);
  /// Its other layers.
  void fetch_window(Cuda& cuda, HostMemory& host);
  /// Final grids: the vehicle's, the observed one and the window's occupancy.
  void fetch_final(Cuda& cuda, HostMemory& host);
  /// Waits for them.
  void fetch_stages(Cuda& cuda, StageImages& stages) const;

  FrameLayout layout;
  DeviceBuffer<std::byte> input;
  DeviceBuffer<std::byte> output;
  DeviceBuffer<FrameSetOnDevice> set;
  DeviceBuffer<float> grids;        ///< see PackedGrids
  DeviceImage<std::uint8_t> left;   ///< in the input
  DeviceImage<std::uint8_t> right;  ///< likewise
  DeviceImage<float> given;         ///< likewise
  DeviceImage<float> lattice;       ///< in the output
  DeviceImage<std::uint8_t> aligned;
  DeviceImage<std::uint8_t> masked;  ///< PixelMask, where there is one
  DeviceMatches matches;
  TerrainOnDevice terrain;
  MatchingWorkspaceOnDevice matching;
  UDisparityOnDevice u_disparity;
  ProjectionOnDevice projection;
  RaysOnDevice rays;
  OtherGridsOnDevice other_grids;
  FilterOnDevice filter;
  std::array<FilterStateOnDevice, 2> states;
  DeviceImage<float> observed;  ///< in the grids
  DeviceImage<float> observed_window;
  LayersOnDevice world;    ///< in the grids
  LayersOnDevice vehicle;  ///< likewise
};

/// Marks on the stream, between which time is measured.
class StreamTimes {
 public:
  enum Mark {
    exchanged,
    start,
    uploaded,
    matched,
    answered,
    measured,
    beside,
    grounded,
    resumed,
    counted,
    projected,
    seen,
    observed,
    fused,
    filtering,
    filtered,
    fetched,
    finishing,
    finished
  };
  static constexpr int marks{19};

  StreamTimes();
  StreamTimes(const StreamTimes&) = delete;
  StreamTimes& operator=(const StreamTimes&) = delete;
  ~StreamTimes();
  /// Also within a graph, for the times of its launches.
  void mark(Cuda& cuda, Mark which);
  void mark(cudaStream_t stream, Mark which);
  [[nodiscard]] cudaEvent_t event(Mark which) const { return events_[which]; }
  /// Waits for the last call of `mark` outside a graph.
  void wait_for(Mark which);
  /// Lets further work of `other` wait for the last call of `mark` outside a graph.
  void let_wait(Cuda& other, Mark which) const;
  /// Milliseconds in the last frame; both marks must have been reached.
  [[nodiscard]] double between(Mark from, Mark to) const;
  /// The upload belongs to match, the download to filter. `has_observed`: the camera had a frame; `has_filtered`:
  /// all cameras' were filtered here.
  [[nodiscard]] StageTimes stages(bool has_observed, bool has_filtered) const;

 private:
  std::array<cudaEvent_t, marks> events_{};
};

}  // namespace stereogrid
