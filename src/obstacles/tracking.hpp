// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "held_bytes.hpp"
#include "motion/scene_flow.hpp"
#include "motion/symmetric2.hpp"
#include "obstacles/segments.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid {

/// Along the world's axes.
struct Bounds {
  Point2 least;
  Point2 most;

  /// How far `other` lies away from these, moved; 0: they overlap.
  [[nodiscard]] double gap_to(const Bounds& other, Point2 moved) const;
  [[nodiscard]] bool hold(Point2 at) const {
    return at.x >= least.x && at.x <= most.x && at.y >= least.y && at.y <= most.y;
  }
};

/// A segment on the ground. World axes.
struct Cluster {
  Point2 centre;                   ///< middle of its box
  Point2 velocity;                 ///< of its cells, or of the points followed on it
  Symmetric2 velocity_covariance;  ///< m²/s², of the points; 0: there are none
  double occupancy{0};             ///< mean over its surface
  int pixels{0};
  double length_m{0};
  double width_m{0};
  double yaw_rad{0};
  double height_m{0};
  ObstacleKind kind{ObstacleKind::thing};
  Outline outline;
  Bounds bounds{};  ///< of the outline

  /// By points that have been followed.
  [[nodiscard]] bool has_measured_velocity() const { return velocity_covariance.xx > 0; }
};

/// So many clusters, tracks and obstacles have room from the start, far more than a street has; as many as there might
/// be, a few cells each, would be a waste. More make room once.
constexpr std::size_t things_reserved{1024};

/// Clusters, and what they are found in. Allocated once.
struct ClusterSpace {
  /// A point that has been followed on a cluster.
  struct Followed {
    int label;
    std::size_t vector;
    Segmenter::Spot spot;
  };
  /// `points` that are followed have room from the start.
  ClusterSpace(const Rig& level_rig, const UDisparityConfig& heights, int disparities, std::size_t points = 0);

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(segmenter, clusters, followed, values); }

  Segmenter segmenter;
  Rig rig;
  std::vector<Cluster> clusters;   ///< one for each segment
  std::vector<Followed> followed;  ///< by label
  std::vector<double> values;      ///< of a cluster's points, or columns
};

/// Separates what moves from what stands within a segment, where points of both have been followed.
void separate_movers(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterSpace& space);

/// A cluster for each segment, with its outline, and with occupancy and velocity as the filtered grid has them.
void describe_segments(const GridLayers& world, const Pose2& world_from_vehicle, ClusterSpace& space);

/// Gives each cluster the velocity of the points that have been followed on it.
void measure_velocities(const std::vector<FlowVector>& vectors, const Pose2& world_from_vehicle, ClusterSpace& space);

/// Around the outlines: along the motion of what moves, else the smallest.
void fit_boxes(std::vector<Cluster>& clusters);

/// Clusters of the disparities of obstacles, (H, W) px, and of points followed to them. `for_ranges`: see
/// Segmenter::find.
template <class ForRanges>
void find_clusters(View<const float> obstacle, const Ground& ground, const GridLayers& world,
                   const Pose2& world_from_vehicle, const std::vector<FlowVector>& vectors, const ForRanges& for_ranges,
                   ClusterSpace& space) {
  space.segmenter.find(obstacle, ground, for_ranges);
  separate_movers(vectors, world_from_vehicle, space);
  describe_segments(world, world_from_vehicle, space);
  measure_velocities(vectors, world_from_vehicle, space);
  fit_boxes(space.clusters);
}

/// Follows clusters through time: nearest-neighbour association within a gate around each track's prediction, a
/// constant-velocity Kalman filter for each track, ids that are never used twice. docs/method.md §11.
class Tracker {
 public:
  Tracker(const TrackingConfig& config, const Rig& level_rig);

  /// No tracks; ids go on.
  void forget() { tracks_.clear(); }
  /// Ids go on from those of `before`.
  void go_on_from(const Tracker& before) { next_id_ = before.next_id_; }

  /// Moves all tracks on by dt_s, gives each its cluster, begins and ends tracks.
  void update(const GridLayers& world, const std::vector<Cluster>& clusters, const Pose2& world_from_vehicle,
              double dt_s);

  /// The tracks as obstacles in the vehicle frame.
  void report(const Pose2& world_from_vehicle, std::vector<Obstacle>& obstacles) const;

  template <class State>
  void exchange(State& state) {
    state(tracks_, next_id_);
    if constexpr (requires { state.require(true); }) {
      for (const Track& track : tracks_) {
        state.require(track.shape.outline.size() <= Outline::points_max && track.shape.kind <= ObstacleKind::extended);
      }
    }
  }

  [[nodiscard]] std::size_t held_bytes() const {
    return held_bytes_of(tracks_, pairs_, is_track_taken_, is_cluster_taken_);
  }

 private:
  // One axis of a constant-velocity Kalman filter.
  struct Axis {
    double position{0};
    double velocity{0};
    std::array<double, 3> covariance{};  // pp, pv, vv

    void predict(double dt_s, double acceleration_mps2);
    void update_position(double measured, double variance);
    void update_velocity(double measured, double variance);
  };

  struct Track {
    std::int64_t id{0};
    Axis x;
    Axis y;
    Cluster shape;
    int sightings{0};
    std::int64_t pixels{0};  ///< of all sightings
    double moving{0};        ///< evidence that it moves: logarithm of the odds
    double age_s{0};
    double unseen_s{0};
    Point2 moved;  ///< since it was last seen, as predicted
  };

  // A cluster that may be a track's.
  struct Pair {
    double distance;
    std::size_t track;
    std::size_t cluster;
  };

  static bool differs(const Cluster& cluster, const Track& track);
  void find_pairs(const std::vector<Cluster>& clusters);
  void associate(const std::vector<Cluster>& clusters);
  static double evidence_of_motion(const Cluster& cluster);
  void correct(Track& track, const Cluster& cluster) const;
  void begin_track(const Cluster& cluster);
  [[nodiscard]] bool is_confirmed(const Track& track) const;
  static bool is_replaced(const Track& track, const std::vector<Cluster>& clusters);
  [[nodiscard]] bool is_over(const Track& track, const GridLayers& world, const Pose2& vehicle_from_world) const;

  TrackingConfig config_;
  Rig rig_;
  std::vector<Track> tracks_;
  std::vector<Pair> pairs_;  // working memory, as the next two
  std::vector<std::uint8_t> is_track_taken_;
  std::vector<std::uint8_t> is_cluster_taken_;
  std::int64_t next_id_{1};
};

}  // namespace stereogrid
