// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/evaluation/tracking.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/obstacle.hpp"

namespace stereogrid::evaluation {

/// Something that an obstacle should stand for: a car, a person, a pole. Vehicle frame.
struct Thing {
  std::int64_t id{0};
  std::string kind;
  std::vector<Point2> seen;       ///< places on it that the camera sees, from 3 to 20 m ahead
  double reach_m{0};              ///< maximum distance of an outline
  std::vector<Point2> footprint;  ///< polygon
  double area_m2{0};              ///< area of the footprint
  Point2 centre;                  ///< centre of the box around the footprint, along the thing's heading
  double length_m{0};             ///< size of that box
  double width_m{0};
  std::optional<Point2> velocity_mps;  ///< over ground; moving objects only
};

/// Truth of one frame's obstacles.
struct ObstacleTruth {
  /// Around something that moves.
  struct Circle {
    Point2 centre;
    double radius_m{0};
  };
  std::vector<Thing> things;
  std::vector<Circle> movers;
  double sigma_per_m2{0};        ///< standard deviation of a depth over its square; 0: near sides are not scored
  bool has_cell_truth{false};    ///< free space is labelled
  std::vector<Point2> free;      ///< centres of the cells that are seen free, from 3 to 20 m ahead
  std::vector<Point2> occupied;  ///< likewise
};

/// Builds it from exact truth. Things exclude buildings, walls, hedges, trees, kerbs, fences and ground, and have 250
/// pixels or more and at least two seen cells. Those faster than 0.5 m/s move; from 0.3 m/s on they have a circle.
/// `rig`: of the recording.
[[nodiscard]] STEREOGRID_EXPORT ObstacleTruth obstacle_truth(const FrameTruth& truth, const TruthGrid& truth_grid,
                                                             const Rig& rig);

/// Builds it from labelled boxes. Things are not largely hidden, and at least 8 of 22 points on the two sides that face
/// the camera lie 3 to 20 m ahead within the image's columns. `cells`: labels of the frame's cells; nullptr: none.
[[nodiscard]] STEREOGRID_EXPORT ObstacleTruth obstacle_truth(std::span<const LabelledObject> objects, const Rig& rig,
                                                             const Labels* cells);

/// The first second of a drive is not scored: the first ten frames of its truth, if there are more than twelve.
[[nodiscard]] constexpr bool is_settled(std::size_t place, std::size_t frames) {
  return place >= 10 || frames <= 12;
}

/// Figures defined in docs/evaluation.md. NaN: undefined.
struct ObstacleSummary {
  static constexpr double nothing{std::numeric_limits<double>::quiet_NaN()};
  struct Kind {
    std::size_t things{0};
    std::size_t separate{0};
  };
  std::size_t frames{0};
  std::size_t things{0};  ///< × frames
  double separate{nothing};
  std::map<std::string, Kind> by_kind;
  double found{nothing};
  double in_extended{nothing};
  double merged{nothing};
  double split{nothing};
  std::size_t free_cells{0};
  double free_covered{nothing};
  std::size_t moving{0};
  double moving_wrong{nothing};
  std::size_t moving_cells{0};
  double moving_cells_standing{nothing};
  double speed_error_mps{nothing};  ///< length of the difference of velocities
  double area_median_m2{nothing};
  double area_p90_m2{nothing};
  double corners{nothing};      ///< mean number of an outline's distinct points
  double turns_per_m{nothing};  ///< corners of more than 30° per metre of outline

  bool has_complete_truth{false};  ///< truth allows to find false obstacles; otherwise false_positives and the
                                   ///< following are void
  TrackingSummary tracking;

  // Medians over the matches of `tracking`.
  double centre_error_m{nothing};
  double nearest_edge_error_m{nothing};
  double near_side_sigmas{
      nothing};  ///< mean distance of near sides along the rays, in standard deviations of the depth
  double length_error_m{nothing};
  double width_error_m{nothing};
  std::size_t movers{0};
  double mover_speed_error_mps{nothing};  ///< difference of the lengths of velocities
  std::size_t headings{0};
  double heading_error_deg{nothing};
};

/// Whether confirmed obstacles are things that a planner can use.
class STEREOGRID_EXPORT ObstacleScores {
 public:
  /// `moving_cells`: centres of the grid's cells that seem to move, from 3 to 20 m ahead.
  void add(const ObstacleTruth& truth, std::span<const Obstacle> reported, std::span<const Point2> moving_cells = {});
  [[nodiscard]] ObstacleSummary summary() const;

 private:
  struct Candidate;
  using Candidates = std::vector<Candidate>;
  using Shares = std::vector<double>;  // [thing][candidate]: shares of the thing's seen points
  [[nodiscard]] static Candidates candidates_of(std::span<const Obstacle> reported);
  void add_cells(const ObstacleTruth& truth, const Candidates& candidates);
  void add_outlines(const Candidates& candidates);
  void add_moving_cells(std::span<const Point2> cells, const Candidates& candidates);
  void add_motion(const ObstacleTruth& truth, const Candidates& candidates);
  void add_thing(const Thing& thing, std::span<const double> shares, const Candidates& candidates);
  void add_merged(const ObstacleTruth& truth, const Shares& shares, const Candidates& candidates);
  void add_tracks(const ObstacleTruth& truth, const Shares& shares, const Candidates& candidates);
  void add_errors(const Thing& thing, const Candidate& candidate);
  void add_near_side(const Thing& thing, const Candidate& candidate, double sigma_per_m2);

  struct Counts {
    std::size_t frames{0};
    std::size_t things{0};
    std::size_t separate{0};
    std::size_t found{0};
    std::size_t in_extended{0};
    std::size_t merged{0};
    std::size_t split{0};
    std::size_t free{0};
    std::size_t covered{0};
    std::size_t moving{0};
    std::size_t moving_wrong{0};
    std::size_t moving_cells{0};
    std::size_t moving_cells_standing{0};
    std::size_t outlines{0};
    std::size_t corners{0};
    std::size_t turns{0};
    std::size_t rays{0};
    bool has_cell_truth{false};
  } counts_;
  double outlines_m_{0};   ///< length of all
  double near_sigmas_{0};  ///< sum over the rays
  struct Errors {
    std::vector<double> velocity_mps;
    std::vector<double> centre_m;
    std::vector<double> nearest_edge_m;
    std::vector<double> length_m;
    std::vector<double> width_m;
    std::vector<double> speed_mps;
    std::vector<double> heading_deg;
  } errors_;
  std::map<std::string, ObstacleSummary::Kind> by_kind_;
  std::vector<double> areas_m2_;
  TrackingScores tracking_;
};

}  // namespace stereogrid::evaluation
