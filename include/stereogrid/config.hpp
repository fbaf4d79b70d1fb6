// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// Parameter metadata: name, unit, range (both ends allowed) and description. Unit "" is a plain number.
struct Parameter {
  std::string_view name;
  std::string_view unit;
  double minimum;
  double maximum;
  std::string_view sentence;
};

// Every parameter is declared once: its default where it stands, the rest in its struct's visit_fields. YAML, the
// command line, run.json and docs/config.md are loops over visit_fields.

struct GridConfig {
  double length_m{20};
  double width_m{20};
  double cell_size_m{0.2};
  double rear_m{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"length_m", "m", 1, 500, "Length of the grid ahead of the vehicle's origin."}, self.length_m);
    visit({"width_m", "m", 1, 500, "Width of the grid, half of it to each side."}, self.width_m);
    visit({"cell_size_m", "m", 0.02, 5, "Side of a square cell."}, self.cell_size_m);
    visit({"rear_m", "m", 0, 500, "Length of the grid behind the vehicle's origin, for cameras that look there."},
          self.rear_m);
  }
};

struct MatchingConfig {
  bool align_rows{true};
  int disparities{0};
  int window_px{9};
  double uniqueness{0};
  double texture{0.75};
  double cost_limit{0.37};
  int left_right_px{2};
  int speckle_px{40};
  int road_speckle_px{200};
  bool subpixel{true};
  bool thin_tops{true};
  double external_sigma_px{0};
  double external_sigma_per_m{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"align_rows", "", 0, 1, "Estimate and correct the vertical misalignment of the right image."},
          self.align_rows);
    visit({"disparities", "px", 0, 256,
           "Number of disparities searched, from 0. 0: automatic, at least 64, a tenth of the image's width, and "
           "those of the road in view."},
          self.disparities);
    visit({"window_px", "px", 3, 41, "Side of the square correlation window, odd."}, self.window_px);
    visit({"uniqueness", "", 0, 1, "Reject a match unless every other disparity costs more by this share of its cost."},
          self.uniqueness);
    visit({"texture", "grey levels", 0, 255,
           "Reject a match where the window's mean horizontal contrast |L(u+1) − L(u−1)| is below this."},
          self.texture);
    visit({"cost_limit", "", 0, 1,
           "Reject a match whose cost exceeds this share of the maximum cost. "
           "Unrelated image regions reach 0.4."},
          self.cost_limit);
    visit({"left_right_px", "px", 0, 255,
           "Reject a match if a cheaper one claims its pixel in the right image with a disparity that differs "
           "by more."},
          self.left_right_px);
    visit({"speckle_px", "px", 0, 100000, "Remove connected patches of fewer obstacle pixels; 0: keep all."},
          self.speckle_px);
    visit({"road_speckle_px", "px", 0, 100000, "Remove connected patches of fewer road pixels; 0: keep all."},
          self.road_speckle_px);
    visit({"subpixel", "", 0, 1, "Refine disparities between the integers on the winner's cost curve."}, self.subpixel);
    visit({"thin_tops", "", 0, 1, "Search thin, wide things above the road, such as tops of tables."}, self.thin_tops);
    visit({"external_sigma_px", "px", 0, 10,
           "External disparities: standard deviation. 0: estimated from the disparities of each frame."},
          self.external_sigma_px);
    visit({"external_sigma_per_m", "1/m", 0, 1,
           "External depth: standard deviation divided by the square of the depth, in place of external_sigma_px. 0: "
           "external_sigma_px."},
          self.external_sigma_per_m);
  }
};

enum class GroundModel { plane, terrain };
constexpr std::array<std::string_view, 2> names_of(GroundModel) {
  return {"plane", "terrain"};
}

struct GroundConfig {
  GroundModel model{GroundModel::terrain};
  bool estimate{true};
  double height_gate_m{0.25};
  double pitch_gate_deg{4.5};
  double roll_gate_deg{6.0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"model", "", 0, 1,
           "plane: pixels above the ground plane are obstacles; terrain: steps, slopes and edges are found, "
           "cells are free where the vehicle can drive."},
          self.model);
    visit({"estimate", "", 0, 1, "Estimate the ground plane in every frame; off: use the calibration."}, self.estimate);
    visit({"height_gate_m", "m", 0, 2, "Maximum deviation from the calibrated camera height."}, self.height_gate_m);
    visit({"pitch_gate_deg", "deg", 0, 20, "Maximum deviation from the calibrated pitch."}, self.pitch_gate_deg);
    visit({"roll_gate_deg", "deg", 0, 20, "Maximum deviation from the calibrated roll."}, self.roll_gate_deg);
  }
};

/// The volume above the ground in which a pixel counts as part of an obstacle.
struct UDisparityConfig {
  double obstacle_height_m{1.8};
  double obstacle_min_height_m{0.25};
  bool follow_roll{true};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"obstacle_height_m", "m", 0.2, 10, "Height h of the volume that must be free (eq. 9)."},
          self.obstacle_height_m);
    visit({"obstacle_min_height_m", "m", 0, 2,
           "Minimum height of obstacle pixels above the road; lower ones count in N_V, not in N_O."},
          self.obstacle_min_height_m);
    visit({"follow_roll", "", 0, 1, "Tilt the rows of a bin with the roll of the road."}, self.follow_roll);
  }
};

/// Limits of the vehicle. Used with ground.model terrain.
struct VehicleConfig {
  double step_max_m{0.15};
  double slope_max_deg{20};
  double height_m{1.8};
  double drop_slope_deg{6};
  double ground_memory_s{10};
  double reaction_s{0.3};
  double deceleration_mps2{2};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"step_max_m", "m", 0.01, 1, "Largest step that the vehicle climbs or descends."}, self.step_max_m);
    visit({"slope_max_deg", "deg", 1, 45, "Steepest slope that the vehicle drives on."}, self.slope_max_deg);
    visit({"height_m", "m", 0.1, 10, "Clearance: pixels higher above the ground are not obstacles."}, self.height_m);
    visit({"drop_slope_deg", "deg", 0.5, 45,
           "A gap with lower ground behind it is a drop where the line of sight is steeper than this."},
          self.drop_slope_deg);
    visit({"ground_memory_s", "s", 0.1, 1000, "Time for which ground that was seen keeps a cell free."},
          self.ground_memory_s);
    visit({"reaction_s", "s", 0, 10, "Time from a frame to the brakes; for the speed limit."}, self.reaction_s);
    visit({"deceleration_mps2", "m/s2", 0.1, 20, "Deceleration of the brakes; likewise."}, self.deceleration_mps2);
  }
};

/// Road pixels that count as rays which passed a cell.
enum class RoadRays { none, visible };
constexpr std::array<std::string_view, 2> names_of(RoadRays) {
  return {"none", "visible"};
}

/// Parameters of the u-disparity bins of the paper (eqs. 5 to 15). Stage images and visualisations show these bins;
/// the grids use them if projection.model is bins.
struct PaperConfig {
  double false_positive{0.02};
  double false_negative{0.02};
  double tau_obstacle{0.07};
  double tau_road{0.1};
  double sigma_disparity{0.5};
  double sigma_column{0.7};
  RoadRays road_rays{RoadRays::visible};
  int small_count_guard{2};
  bool left_border{true};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"false_positive", "", 0.001, 0.4, "P_FP of eq. 5."}, self.false_positive);
    visit({"false_negative", "", 0.001, 0.4, "P_FN of eq. 6."}, self.false_negative);
    visit({"tau_obstacle", "", 0.001, 10, "tau_O of eq. 13: the filled share of a column that counts."},
          self.tau_obstacle);
    visit({"tau_road", "", 0.001, 10, "tau_R of eq. 15."}, self.tau_road);
    visit({"sigma_disparity", "px", 0, 5, "Standard deviation of the smoothing along disparity; 0: none."},
          self.sigma_disparity);
    visit({"sigma_column", "px", 0, 20, "Standard deviation of the smoothing along columns; 0: none."},
          self.sigma_column);
    visit({"road_rays", "", 0, 1,
           "none: only obstacle pixels are rays (the paper); visible: road pixels are rays that passed."},
          self.road_rays);
    visit({"small_count_guard", "px", 0, 50, "Added to N_V in r_O so that a lone outlier is not an obstacle."},
          self.small_count_guard);
    visit({"left_border", "", 0, 1,
           "Leave bins unknown that the right camera cannot see (u below disparity + half a window)."},
          self.left_border);
  }
};

enum class ProjectionModel { bins, rays };
constexpr std::array<std::string_view, 2> names_of(ProjectionModel) {
  return {"bins", "rays"};
}

struct ProjectionConfig {
  ProjectionModel model{ProjectionModel::rays};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"model", "", 0, 1,
           "bins: the largest probability of the u-disparity bins that touch a cell (eq. 16); rays: a fitted "
           "model of the rays that end in a cell, around it, and behind it."},
          self.model);
  }
};

struct FusionConfig {
  double stereo_confidence{0.95};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"stereo_confidence", "", 0, 1,
           "Confidence in the stereo grid in frames with grids of other sources; 0: stereo is not used."},
          self.stereo_confidence);
  }
};

/// The forms of the Bayesian Occupancy Filter.
enum class FilterModel { tay2008, joint };
constexpr std::array<std::string_view, 2> names_of(FilterModel) {
  return {"tay2008", "joint"};
}

struct FilterConfig {
  FilterModel model{FilterModel::joint};
  std::vector<double> speeds_mps{1.25, 2.52, 3.94, 5.75, 8.34, 12.2};  // fine enough for pedestrians, as fast as cars
  double decay_time_s{2};
  double decay_time_in_view_s{0.5};
  double velocity_noise{0.01};
  double likelihood_exponent{0.8};
  double static_prior{0.85};
  bool scene_flow{true};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"model", "", 0, 1, "tay2008: velocity given the cell; joint: mass of (occupied, velocity)."}, self.model);
    visit({"speeds_mps", "m/s", 0.1, 60,
           "Velocities of the lattice along each world axis, in both directions, ascending; 0 is added."},
          self.speeds_mps);
    visit({"decay_time_s", "s", 0.05, 1000, "Time constant of the decay of unobserved cells to unknown."},
          self.decay_time_s);
    visit({"decay_time_in_view_s", "s", 0.05, 1000,
           "The same for cells in the camera's field of view that are not confirmed; joint only."},
          self.decay_time_in_view_s);
    visit({"velocity_noise", "", 0.0001, 0.9,
           "Share of the dynamic mass that changes its velocity in 0.1 s. If static_prior > 0, static mass has a "
           "tenth of it."},
          self.velocity_noise);
    visit({"likelihood_exponent", "", 0.05, 1,
           "Exponent of a frame's likelihood, below 1 because stereo errors are correlated over time; 1: full "
           "evidence."},
          self.likelihood_exponent);
    visit({"static_prior", "", 0, 0.99,
           "Static share of new mass; 0: uniform over all velocities including standstill (2008)."},
          self.static_prior);
    visit({"scene_flow", "", 0, 1,
           "Track features of obstacles in both images; their velocities are evidence for the filter (joint) and "
           "the tracks."},
          self.scene_flow);
  }
};

struct TrackingConfig {
  int confirm_frames{3};
  double coast_s{1.0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"confirm_frames", "frames", 1, 50,
           "Sightings before an obstacle of fewer than 300 matched pixels counts as confirmed."},
          self.confirm_frames);
    visit({"coast_s", "s", 0, 10, "Time for which an unobserved track is predicted before it ends."}, self.coast_s);
  }
};

/// Poses over time.
struct MotionConfig {
  bool detect_jumps{true};
  double gap_max_s{5};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit({"detect_jumps", "", 0, 1,
           "Continue with the last motion at pose jumps and shift the pose frame; off: follow the poses."},
          self.detect_jumps);
    visit({"gap_max_s", "s", 0.05, 3600, "Longer time between frames resets all state, tracks included."},
          self.gap_max_s);
  }
};

/// Every parameter of the pipeline. Keys are `group.name`, as in `grid.length_m`.
struct Config {
  GridConfig grid;
  MatchingConfig matching;
  GroundConfig ground;
  VehicleConfig vehicle;
  UDisparityConfig u_disparity;
  PaperConfig paper;
  ProjectionConfig projection;
  FusionConfig fusion;
  MotionConfig motion;
  FilterConfig filter;
  TrackingConfig tracking;

  template <class Self, class Visitor>
  static void visit_groups(Self& self, Visitor&& visit) {
    visit(std::string_view{"grid"}, self.grid);
    visit(std::string_view{"matching"}, self.matching);
    visit(std::string_view{"ground"}, self.ground);
    visit(std::string_view{"vehicle"}, self.vehicle);
    visit(std::string_view{"u_disparity"}, self.u_disparity);
    visit(std::string_view{"paper"}, self.paper);
    visit(std::string_view{"projection"}, self.projection);
    visit(std::string_view{"fusion"}, self.fusion);
    visit(std::string_view{"motion"}, self.motion);
    visit(std::string_view{"filter"}, self.filter);
    visit(std::string_view{"tracking"}, self.tracking);
  }
};

/// Calls visit(group, parameter, value&) for every parameter of a (const) Config.
template <class ConfigType, class Visitor>
void visit_parameters(ConfigType& config, Visitor&& visit) {
  Config::visit_groups(config, [&](std::string_view group, auto& fields) {
    std::remove_cvref_t<decltype(fields)>::visit_fields(
        fields, [&](const Parameter& parameter, auto& value) { visit(group, parameter, value); });
  });
}

/// "default", "robot" or "paper". Throws ConfigError for other names.
[[nodiscard]] STEREOGRID_EXPORT Config preset(std::string_view name);
/// Names that preset() takes.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> preset_names();

/// Sets `key` ("group.name") from text. Throws ConfigError: unknown key, text that is no value.
STEREOGRID_EXPORT void set(Config& config, std::string_view key, std::string_view text);

/// Value of `key` as text for `set`.
[[nodiscard]] STEREOGRID_EXPORT std::string get(const Config& config, std::string_view key);

/// Problems of a configuration, one message each; empty if it is valid.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> problems(const Config& config);

}  // namespace stereogrid
