// SPDX-License-Identifier: Apache-2.0
#include "ground/frame_validator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "images/patch.hpp"
#include "matching/checks/external.hpp"

namespace stereogrid {
namespace {

// Minimum share of texture that has matched. Real drives have 0.79 and more; invalid pairs have up to 0.23 (swapped,
// vertically misaligned, noise) or 0.51 (a frame apart).
constexpr double texture_matched_min{0.6};
// Minimum difference of texture between neighbours, in grey levels and in noise sigmas: noise does not match.
constexpr int texture_grey{4};
constexpr double texture_sigmas{3};
template <class Visit>
void for_lattice(const MatchedFrame& frame, double first_row, const Visit& visit) {
  const MatchLattice lattice{frame.left.width, frame.left.height};
  for (int j{0}; j < lattice.down; ++j) {
    const int v{MatchLattice::first_v + j * MatchLattice::step_v};
    if (v < first_row) continue;
    for (int i{0}; i < lattice.across; ++i) {
      const int u{MatchLattice::first_u + i * MatchLattice::step_u};
      if (frame.masked.empty() || frame.masked(u, v) == 0) visit(u, v);
    }
  }
}

float disparity_at(const MatchedFrame& frame, int u, int v) {
  return std::max(frame.matches.obstacle(u, v), frame.matches.road(u, v));
}

/// Grey levels of both images at the same places.
struct PairCounts {
  GreyCounts left{};
  GreyCounts right{};
};

PairCounts counts_of(const MatchedFrame& frame) {
  PairCounts counts;
  for_lattice(frame, 0, [&](int u, int v) {
    ++counts.left[frame.left(u, v)];
    ++counts.right[frame.right(u, v)];
  });
  return counts;
}

bool are_identical(const MatchedFrame& frame) {
  for (int v{0}; v < frame.left.height; ++v) {
    if (!std::equal(frame.left.row(v), frame.left.row(v) + frame.left.width, frame.right.row(v))) return false;
  }
  return true;
}

bool has_disparities(View<const float> external, int disparities) {
  for (int v{0}; v < external.height; ++v) {
    const float* row{external.row(v)};
    if (std::any_of(row, row + external.width, [&](float d) { return is_usable(d, disparities); })) return true;
  }
  return false;
}

Rejection::Reason reason_of_few(const MatchedFrame& frame) {
  if (frame.is_external()) return Rejection::no_disparities;
  return are_identical(frame) ? Rejection::identical_images : Rejection::few_matches;
}

}  // namespace

double noise_of(const MatchedFrame& frame, double first_row) {
  constexpr double sigmas_per_median{1.4826};
  constexpr int differences_max{4 * 255};
  std::array<int, differences_max + 1> counts{};
  int all{0};
  for_lattice(frame, first_row, [&](int u, int v) {
    ++counts[static_cast<std::size_t>(std::abs(frame.left(u - 1, v) - 2 * frame.left(u, v) + frame.left(u + 1, v)))];
    ++all;
  });
  int median{0};
  for (int below{counts[0]}; 2 * below < all; below += counts[static_cast<std::size_t>(++median)]) {
  }
  return sigmas_per_median * median / std::sqrt(6.0);  // 1² + 2² + 1²
}

double textured_from(const MatchedFrame& frame, double first_row) {
  return std::max<double>(texture_grey, texture_sigmas * noise_of(frame, first_row));
}

double share_of_texture_matched(const MatchedFrame& frame, double first_row, const RoadPlane& road, int disparities,
                                const GreyTransfer* right_of_left) {
  const double least_grey{textured_from(frame, first_row)};
  int all{0};
  int all_matched{0};
  int textured{0};
  int textured_matched{0};
  for_lattice(frame, first_row, [&](int u, int v) {
    if (road.disparity(u, v) > disparities - 1) return;
    const int matched{frame.matches.obstacle(u, v) > 0 || frame.matches.road(u, v) > 0 ? 1 : 0};
    ++all;
    all_matched += matched;
    const std::uint8_t before{frame.left(u - 1, v)};
    const std::uint8_t after{frame.left(u + 1, v)};
    if (std::abs(after - before) < least_grey) return;
    if (right_of_left != nullptr && std::abs((*right_of_left)[after] - (*right_of_left)[before]) < texture_grey) return;
    ++textured;
    textured_matched += matched;
  });
  if (all == 0) return 1;
  if (100 * textured < all) return static_cast<double>(all_matched) / all;
  return static_cast<double>(textured_matched) / textured;
}

double width_falling_away(const MatchedFrame& frame, const Rig& rig, const RoadPlane& plane) {
  constexpr double path_m{1};
  constexpr double descent{0.1051};  // tan 6°
  constexpr int run_min{3};
  const double least_px{std::hypot(plane.per_u, plane.per_v) * rig.focal_px * descent};
  const MatchLattice lattice{frame.left.width, frame.left.height};
  double width_m{0};
  for (int i{0}; i < lattice.across; ++i) {
    const int u{MatchLattice::first_u + i * MatchLattice::step_u};
    int run{0};
    for (int j{0}; j < lattice.down && run < run_min; ++j) {
      const int v{MatchLattice::first_v + j * MatchLattice::step_v};
      const double expected_px{plane.disparity(u, v)};
      const double disparity{disparity_at(frame, u, v)};
      const bool is_in_path{std::abs(u - rig.cx_px) * rig.baseline_m <= path_m * expected_px};
      if (expected_px < least_px || !is_in_path || !(disparity > 0)) continue;
      run = disparity < 0.9 * expected_px - 1.5 ? run + 1 : 0;
      if (run == run_min) width_m += MatchLattice::step_u * rig.baseline_m / expected_px;
    }
  }
  return width_m;
}

bool has_few_matches(const MatchedFrame& frame, const Rig& level_rig, const Ground& ground, int disparities) {
  if (frame.is_external()) return !has_disparities(frame.external, disparities);
  // the horizon may lie below the image
  const double first_row{std::min(horizon_row(level_rig, ground), level_rig.height_px / 2.0)};
  const RoadPlane road{road_plane(level_rig, ground)};
  if (share_of_texture_matched(frame, first_row, road, disparities) >= texture_matched_min) return false;
  const PairCounts counts{counts_of(frame)};
  if (!is_unequal(exposure_of(counts.left, counts.right))) return true;
  const GreyTransfer right_of_left{transfer_of(counts.left, counts.right)};
  return share_of_texture_matched(frame, first_row, road, disparities, &right_of_left) < texture_matched_min;
}

Rejection check_images(const MatchedFrame& frame, const Rig& level_rig, const Ground& plane, int disparities) {
  Rejection rejection;
  if (has_few_matches(frame, level_rig, plane, disparities)) rejection.reason = reason_of_few(frame);
  if (frame.right.empty()) return rejection;
  const PairCounts counts{counts_of(frame)};
  rejection.exposure = exposure_of(counts.left, counts.right);
  return rejection;
}

void report(const Rejection& rejection, FrameResult& result) {
  const auto add = [&](FrameStatus flag, const char* sentence) { result.add(flag, sentence); };
  if (rejection == Rejection::few_matches) {
    add(FrameStatus::few_matches,
        "left and right image hardly match: the grid is unknown. Check that the images are of the same instant, "
        "rectified and not swapped, and that no lens is dark or covered.");
  } else if (rejection == Rejection::identical_images) {
    add(FrameStatus::few_matches,
        "left and right are the same image, or both are black: the grid is unknown. Give the right camera's image.");
  } else if (rejection == Rejection::no_disparities) {
    add(FrameStatus::few_matches,
        "the frame has no disparity from 0.5 px to matching.disparities: the grid is unknown. Give those of its left "
        "image, in px.");
  } else if (rejection == Rejection::plane_contradicted) {
    add(FrameStatus::road_unknown,
        "the ground in view contradicts the extrinsics: the grid is unknown. Measure mount.camera_height_m and "
        "mount.camera_pitch_rad in the calibration.");
  } else if (rejection == Rejection::falls_away) {
    add(FrameStatus::road_unknown,
        "the ground in the vehicle's path falls away (an edge, stairs or a slope down): the grid is unknown.");
  } else if (rejection == Rejection::ground_not_found) {
    add(FrameStatus::road_unknown,
        "the ground is not found yet: the grid is unknown. It may be out of view, wet, without texture, or nearer than "
        "matching.disparities reach. Show more of it, or give mount in the calibration.");
  } else if (rejection == Rejection::road_not_seen) {
    add(FrameStatus::road_unknown,
        "the road has not been visible for more than 3 s: the grid is unknown. If the road is in view, correct mount "
        "in the calibration.");
  }
  result.exposure = rejection.exposure;
  if (is_unequal(result.exposure)) result.warnings.push_back({text_of(result.exposure)});
}

void report_disagreement(const Rig& level_rig, double turned_rad, const Ground& plane, FrameResult& result) {
  // to a tenth, without a sign of zero
  const auto degrees = [](double radians) { return std::round(radians * 1800 / std::numbers::pi) / 10 + 0.0; };
  const Ground seen{seen_from(plane, turned_rad)};
  std::array<char, 400> text{};
  std::snprintf(
      text.data(), text.size(),
      "a plane in view does not fit the extrinsics, which are kept: camera height %.2f m, pitch %.1f°, roll %.1f° "
      "in use; height %.2f m, pitch %.1f°, roll %.1f° seen. The cause may be a slope, stairs, an edge or a "
      "large obstacle. If the camera was moved, correct mount in the calibration.",
      level_rig.camera_height_m, degrees(level_rig.camera_pitch_rad + turned_rad), degrees(level_rig.camera_roll_rad),
      seen.height_m, degrees(seen.pitch_rad), degrees(seen.roll_rad));
  result.add(FrameStatus::extrinsics_disagree, text.data());
}

void report_roll(const Ground& seen, FrameResult& result) {
  constexpr double supported_deg{45};  // largest roll of a calibration
  const double roll_deg{std::round(seen.roll_rad * 180 / std::numbers::pi)};
  std::array<char, 400> text{};
  if (std::abs(roll_deg) > 180 - supported_deg) {
    std::snprintf(text.data(), text.size(),
                  "the images are upside down (a roll of %.0f°): the grid is unknown. Turn both by 180° and exchange "
                  "left and right.",
                  std::abs(roll_deg));
  } else if (std::abs(roll_deg) > supported_deg) {
    std::snprintf(
        text.data(), text.size(),
        "the ground in view is that of a camera rolled by %.0f°: the grid is unknown. Mount the pair with its "
        "baseline level; images turned by 90° do not match.",
        roll_deg);
  } else {
    std::snprintf(
        text.data(), text.size(),
        "the camera is rolled by %.0f°, and extrinsics are estimated up to 12°: the grid is unknown. Mount the "
        "pair with its baseline level, or give mount: {camera_height_m: %.3f, camera_pitch_rad: %.4f, "
        "camera_roll_rad: %.4f} in the calibration. Grids of such a camera are poorer.",
        roll_deg, seen.height_m, seen.pitch_rad, seen.roll_rad);
  }
  result.add(FrameStatus::road_unknown, text.data());
}

void set_unknown(StageImages& stages) {
  std::ranges::fill(stages.possible, 0);
  for (Image<std::uint16_t>* counts : {&stages.visible, &stages.observed}) counts->fill(0);
  for (Image<float>* share : {&stages.visibility, &stages.obstacle_confidence, &stages.road_confidence}) share->fill(0);
  for (Image<float>* occupancy : {&stages.occupancy, &stages.occupancy_smooth}) occupancy->fill(0.5f);
}

}  // namespace stereogrid
