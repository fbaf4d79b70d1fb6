// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "backend/cuda.hpp"
#include "matching/cuda.hpp"
#include "observation/u_disparity/model.hpp"
#include "observation/u_disparity/u_disparity.hpp"

namespace stereogrid {

/// Which rows belong to which bins in this frame, as in BinRows; the pointers are on the device.
struct BinRowsOnDevice {
  std::int32_t* shift;     ///< (W)
  RowRange* rows;          ///< (D)
  BinRange* bins;          ///< [row] from row −margin on, to height + margin
  BinRange* upright_bins;  ///< likewise
  int* possible;           ///< (D) N_P
  int margin;
};

/// The tables of `count`, what it works in, and what it leaves; on the device, allocated and uploaded once.
struct UDisparityOnDevice {
  /// Throws ConfigError: more disparities or rows than counts hold.
  UDisparityOnDevice(Cuda& cuda, const UDisparityTables& tables, int width, int height, int disparities);

  [[nodiscard]] BinRowsOnDevice rows();

  BinConfig config;
  int half_window;
  DeviceBuffer<float> miss;
  DeviceBuffer<float> road_factor;
  DeviceBuffer<float> weights_column;
  DeviceBuffer<float> weights_disparity;

  int margin;
  DeviceBuffer<std::int32_t> shift;
  DeviceBuffer<RowRange> rows_of_bin;
  DeviceBuffer<BinRange> bins_of_row;
  DeviceBuffer<BinRange> upright_bins_of_row;
  DeviceImage<std::uint8_t> has_road;

  // as in StageImages
  DeviceBuffer<int> possible;
  DeviceImage<std::uint16_t> visible;
  DeviceImage<std::uint16_t> observed;
  DeviceImage<float> visibility;
  DeviceImage<float> obstacle_confidence;
  DeviceImage<float> road_confidence;
  DeviceImage<float> occupancy;
  DeviceImage<float> occupancy_smooth;
};

/// N_V, N_O and the bins with road, of the rows that are given. A part of count.
void count_columns(Cuda& cuda, const MatchViews& matches, const BinRowsOnDevice& rows, UDisparityOnDevice& space);

/// `count` of u_disparity.hpp; `ground` is on the device. Equal to the CPU to the bit on the same ground, unless a
/// rounding difference of tan or cos moves the edge of a bin's rows across a whole number.
void count(Cuda& cuda, const MatchViews& matches, const Rig& rig, const Ground* ground, UDisparityOnDevice& space);

}  // namespace stereogrid
