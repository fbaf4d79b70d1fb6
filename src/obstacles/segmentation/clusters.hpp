// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "memory_bytes.hpp"
#include "motion/scene_flow.hpp"
#include "motion/symmetric2.hpp"
#include "obstacles/segmentation/segments.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/obstacle.hpp"
#include "terrain/terrain.hpp"

namespace stereogrid {

/// Rectangle along the world's axes.
struct Bounds {
  Point2 least;
  Point2 most;

  /// Distance of these bounds, moved by `moved`, from `other`; 0: they overlap.
  [[nodiscard]] double gap_to(const Bounds& other, Point2 moved) const;
};

/// Bounds of an outline; zeros if it is empty.
[[nodiscard]] Bounds bounds_of(const Outline& outline);

/// A segment, an edge with lower ground behind it, or a low obstacle, on the ground. World axes.
struct Cluster {
  Point2 centre;                   ///< middle of its box
  Point2 velocity;                 ///< velocity of its tracked features, or of its cells
  Symmetric2 velocity_covariance;  ///< m²/s²; 0: no tracked features
  double occupancy{0};             ///< mean over its surface
  double moving{0};                ///< dynamic share of its occupancy in the filter
  int pixels{0};
  double length_m{0};
  double width_m{0};
  double yaw_rad{0};
  double height_m{0};
  ObstacleKind kind{ObstacleKind::object};
  Outline outline;  ///< outline of its strips, or of an edge
  Outline fitted;   ///< outline fitted to the strips within their noise, for reports; empty: as `outline`
  Bounds bounds{};  ///< bounds of the outline
  /// True: the object may continue beyond the left or right end of its outline, which is hidden or outside the image.
  bool is_cut_left{false};
  bool is_cut_right{false};
  bool is_sure{true};      ///< errors of matching do not explain it: it may confirm a track
  bool is_low{false};      ///< by the memory of low obstacles: a track of its own, without an influence on others
  bool is_seen{true};      ///< in this frame; not part of a saved state
  std::uint8_t camera{0};  ///< index of the camera that sees it; not part of a saved state

  /// Velocity by tracked features.
  [[nodiscard]] bool has_measured_velocity() const { return velocity_covariance.xx > 0; }

  template <class State>
  void exchange(State& state) {
    state(centre, velocity, velocity_covariance, occupancy, moving, pixels, length_m, width_m, yaw_rad, height_m, kind,
          outline, fitted, bounds, is_cut_left, is_cut_right, is_sure, is_low);
  }
};

/// Reserved capacity of clusters, tracks and obstacles: far more than a street has.
constexpr std::size_t things_reserved{1024};

/// Clusters and their working memory. Allocated once.
struct ClusterWorkspace {
  enum class Motion { unknown, stands, moves };
  /// Feature tracked on a cluster.
  struct Followed {
    int label;
    std::size_t vector;
    Segmenter::Spot spot;
    Motion motion{
        Motion::unknown};  ///< `moves`: certainly, and with the velocity of the segment's other moving features
  };
  /// `points`: reserved capacity for tracked features.
  ClusterWorkspace(const Rig& level_rig, int disparities, std::size_t points = 0);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(segmenter, clusters, followed, values); }

  Segmenter segmenter;
  Rig rig;
  std::vector<Cluster> clusters;   ///< one for each segment, then those of edges and of low obstacles
  std::vector<Followed> followed;  ///< by label
  std::vector<double> values;      ///< values of a cluster's features, then of all nodes
};

/// Splits segments whose tracked features are partly dynamic and partly static.
void separate_movers(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterWorkspace& space);

/// Outlines and boxes of the clusters of segments begin … end − 1, whose velocities are set.
void outline_segments(int begin, int end, const Pose2& world_from_vehicle, ClusterWorkspace& space);

/// Sets occupancy of each segment's cluster, and velocity and box where it has no measured one, by its cells in the
/// filtered grid.
void ask_grid(const GridLayers& world, const Pose2& world_from_vehicle, ClusterWorkspace& space);

/// Sets the velocities of clusters with tracked features.
void measure_velocities(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle,
                        ClusterWorkspace& space);

/// Edges of a frame.
struct FrameEdges {
  std::span<const EdgePoint> points;  ///< from left to right
  double sure_m{0};                   ///< length of an edge that errors of matching do not explain
};

/// Clusters of kind drop: edges that are neighbours, from left to right.
void add_drops(const FrameEdges& edges, const GridLayers& world, const Pose2& world_from_vehicle,
               std::vector<Cluster>& clusters);

/// Clusters of low obstacles: two or more cells that touch. They stand. `cells`: of the window of `world`, by rows;
/// sorted by cluster afterwards.
void add_low_objects(std::span<LowObstacleCell> cells, const GridLayers& world, const Pose2& world_from_vehicle,
                     std::vector<Cluster>& clusters);

/// Moves the clusters of a camera to `all`. Of an object that two cameras see, the cluster with more pixels stays.
void fuse_clusters(std::vector<Cluster>& of_camera, std::uint8_t camera, std::vector<Cluster>& all);

/// Boxes around the outlines: along the velocity of dynamic objects, else the smallest ones.
void fit_boxes(std::span<Cluster> clusters);

/// Segments of `nodes`, split by the velocities of tracked features, and a cluster for each, with the velocity of its
/// features and its box. See Segmenter::find. `for_ranges`(count, work): calls work(begin, end) on disjoint parts of
/// [0, count).
template <class ForRanges>
void find_segments(std::span<const ColumnNode> nodes, const Ground& ground, const Relief<Host>& relief,
                   const Pose2& world_from_vehicle, const std::vector<FlowVector>& vectors, const ForRanges& for_ranges,
                   ClusterWorkspace& space) {
  space.segmenter.find(nodes, ground, relief);
  separate_movers(vectors, world_from_vehicle, space);
  space.clusters.assign(space.segmenter.size(), {});
  measure_velocities(vectors, world_from_vehicle, space);
  space.values.resize(nodes.size());
  for_ranges(static_cast<int>(space.clusters.size()),
             [&](int begin, int end) { outline_segments(begin, end, world_from_vehicle, space); });
}

/// Completes the clusters by the filtered grid and edges.
inline void make_clusters(const GridLayers& world, const Pose2& world_from_vehicle, const FrameEdges& edges,
                          ClusterWorkspace& space) {
  const std::size_t segments{space.clusters.size()};
  ask_grid(world, world_from_vehicle, space);
  add_drops(edges, world, world_from_vehicle, space.clusters);
  fit_boxes(std::span{space.clusters}.subspan(segments));
}

}  // namespace stereogrid
