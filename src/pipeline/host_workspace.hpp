// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "filter/filter.hpp"
#include "ground/plane_numbers.hpp"
#include "matching/matching.hpp"
#include "observation/projection/projection.hpp"
#include "observation/rays/rays.hpp"
#include "observation/u_disparity/u_disparity.hpp"
#include "pipeline/results.hpp"

namespace stereogrid {

/// Working memory of predictions.
struct PredictionWorkspace {
  PredictionWorkspace(int cells, const FilterConfig& config)
      : state{cells, config}, layers{grid_layers({0, 0, 1, cells, cells})}, nothing{cells, cells, 0.5f} {}

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(state, layers, nothing); }

  FilterState state;
  GridLayers layers;
  Image<float> nothing;  ///< observed
};

/// Data of the stages on the host, and the filter's state between frames. Allocated once.
struct HostWorkspace {
  HostWorkspace(const Config& config, const Rig& level_rig, const GridGeometry& vehicle_grid, int threads);

  [[nodiscard]] std::size_t memory_bytes() const;

  Image<std::uint8_t> aligned_right;
  Matches matches;
  Image<float> heights;  ///< working memory of split_surfaces
  MatchingWorkspace matching;
  UDisparityTables u_disparity_tables;
  UDisparityWorkspace u_disparity;
  ProjectionWorkspace projection;
  RayWorkspace rays;
  FilterTables filter_tables;
  Image<float> observed_world;
  FilterState filtered;                             ///< state of the last published frame
  FilterState next;                                 ///< written by the frame in work
  std::unique_ptr<PredictionWorkspace> prediction;  ///< null: no predictions
  WeighingWorkspace weighing;
  std::vector<BlockKind> block_kinds;  ///< kinds of the window's layers of the stored result: FilterState::kinds
  std::vector<BlockKind> part_kinds;   ///< kinds of its vehicle's layers, see KnownKinds
};

}  // namespace stereogrid
