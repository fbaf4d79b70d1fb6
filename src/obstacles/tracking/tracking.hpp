// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "memory_bytes.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "obstacles/tracking/motion_state.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid {

/// Follows clusters through time: nearest-neighbour association within a gate around each track's prediction, a Kalman
/// filter for each track, measured by its visible sides, and unique ids.
/// docs/method.md §11.
class Tracker {
 public:
  /// Cluster::camera is an index into `level_rigs`, at most 32.
  Tracker(const TrackingConfig& config, std::vector<Rig> level_rigs);
  Tracker(const TrackingConfig& config, const Rig& level_rig) : Tracker{config, std::vector{level_rig}} {}

  /// Removes all tracks; ids continue.
  void reset() { tracks_.clear(); }
  /// Continues the ids of `before`.
  void continue_ids(const Tracker& before) { next_id_ = before.next_id_; }

  /// Bits of cameras, the first camera's is 1.
  using Cameras = std::uint32_t;
  static constexpr Cameras all_cameras{~Cameras{0}};

  /// Predicts all tracks by dt_s, associates clusters, begins and ends tracks. `held`: ids of tracks that do not end
  /// while they are in view, ascending. `looking`: cameras whose clusters these are; tracks that none of them sees do
  /// not end for being unseen, but for the time.
  void update(const GridLayers& world, const std::vector<Cluster>& clusters, const Pose2& world_from_vehicle,
              double dt_s, std::span<const std::int64_t> held = {}, Cameras looking = all_cameras);

  /// The tracks as obstacles in the vehicle frame. Obstacles beside `vehicle_grid` are not confirmed.
  void report(const Pose2& world_from_vehicle, const GridGeometry& vehicle_grid,
              std::vector<Obstacle>& obstacles) const;
  /// True: the track exists, and has been seen often or large enough not to be a false match.
  [[nodiscard]] bool is_certain(std::int64_t id) const;
  /// Outline of a track's strips at its last observation, vehicle frame. Reported outlines are fitted to it. Empty: no
  /// such track, or a low obstacle.
  [[nodiscard]] Outline strips_of(std::int64_t id, const Pose2& vehicle_from_world) const;

  template <class State>
  void exchange(State& state) {
    state(tracks_, next_id_);
    if constexpr (requires { state.require(true); }) {
      for (const Track& track : tracks_) {
        state.require(track.shape.outline.size() <= Outline::points_max &&
                      track.shape.fitted.size() <= Outline::points_max && track.shape.kind <= ObstacleKind::drop);
      }
    }
  }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(tracks_, pairs_, is_track_taken_, is_cluster_taken_);
  }

 private:
  /// Evidence of motion: a measured velocity is less reliable than its covariance; several frames are more.
  static constexpr double moving_mps{1};
  static constexpr double evidence_of_frame{1.5};
  static constexpr double surely_moving{3};

  struct Track {
    std::int64_t id{0};
    MotionState motion;
    TrackedBox box;           ///< around the place of `motion`
    Cluster shape;            ///< last observation
    double yaw_sigma_rad{0};  ///< standard deviation of the shape's heading
    int sightings{0};
    std::int64_t pixels{0};  ///< sum over all observations
    double moving{0};        ///< evidence that it moves: logarithm of the odds
    double age_s{0};
    double unseen_s{0};
    Point2 moved;               ///< predicted since the last observation
    bool is_remembered{false};  ///< not seen in this frame, but a low obstacle in memory; not part of a saved state
    bool is_merged{false};      ///< observed as a part of another object: not reported until it is separate again

    [[nodiscard]] Point2 middle() const;  ///< centre of the box

    template <class State>
    void exchange(State& state) {
      state(id, motion, box, shape, yaw_sigma_rad, sightings, pixels, moving, age_s, unseen_s, moved, is_merged);
    }
  };

  // A cluster that may be a track's.
  struct Pair {
    bool is_merged;
    double distance_m;
    std::size_t track;
    std::size_t cluster;
  };

  static bool differs(const Cluster& cluster, const Track& track);
  [[nodiscard]] std::optional<double> distance(const Track& track, const Cluster& cluster) const;
  void find_pairs(const std::vector<Cluster>& clusters);
  void associate(const std::vector<Cluster>& clusters, const Pose2& world_from_vehicle);
  [[nodiscard]] const Rig& rig_of(const Cluster& cluster) const { return rigs_[cluster.camera]; }
  void set_shape(Track& track, const Cluster& cluster, const Pose2& camera) const;
  static bool seems_to_move(const Track& track);
  static double axes_of(const Track& track);
  [[nodiscard]] Obstacle obstacle_of(const Track& track, const Pose2& vehicle_from_world) const;
  static double evidence_of_motion(const Cluster& cluster);
  void correct(Track& track, const Cluster& cluster, const Pose2& camera) const;
  void correct_place(Track& track, const Cluster& cluster, const Pose2& camera) const;
  void begin_track(const Cluster& cluster, const Pose2& camera);
  [[nodiscard]] bool is_certain(const Track& track) const;
  static bool is_replaced(const Track& track, const std::vector<Cluster>& clusters);
  void merge_movers();
  static bool are_one_mover(const Track& piece, const Track& whole);
  [[nodiscard]] bool is_expired(const Track& track, bool is_looked_at) const;
  [[nodiscard]] bool is_over(const Track& track, const std::vector<Cluster>& clusters, const GridLayers& world,
                             const Pose2& vehicle_from_world) const;
  /// `at`: vehicle frame.
  [[nodiscard]] bool is_in_view(Point2 at, Cameras cameras = all_cameras) const;
  [[nodiscard]] bool is_hidden(Point2 at, const std::vector<Cluster>& clusters, const Pose2& vehicle_from_world) const;

  TrackingConfig config_;
  std::vector<Rig> rigs_;  // level rigs, by camera
  std::vector<Track> tracks_;
  std::vector<Pair> pairs_;  // working memory, as the next two
  std::vector<std::uint8_t> is_track_taken_;
  std::vector<std::uint8_t> is_cluster_taken_;
  std::int64_t next_id_{1};
};

}  // namespace stereogrid
