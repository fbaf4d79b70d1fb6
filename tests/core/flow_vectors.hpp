// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "motion/scene_flow.hpp"
#include "obstacles/segmentation/clusters.hpp"

namespace stereogrid::test {

inline FlowVector vector_at(Point2 place, Point2 velocity, double sigma_mps = 0.5) {
  const double variance{sigma_mps * sigma_mps};
  return {place, {0.01, 0, 0.01}, velocity, {variance, 0, variance}};
}

/// Finds the clusters of a frame as FramePipeline does.
template <class ForRanges>
void find_clusters(View<const float> obstacle, const Ground& ground, const GridLayers& world,
                   const Pose2& world_from_vehicle, const std::vector<FlowVector>& vectors, const ForRanges& for_ranges,
                   ClusterWorkspace& space) {
  find_segments(obstacle, ground, {}, world_from_vehicle, vectors, for_ranges, space);
  make_clusters(world, world_from_vehicle, vectors, {}, space);
}

}  // namespace stereogrid::test
