// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "diagnostics/frame_tally.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

constexpr double degrees_per_rad{180 / std::numbers::pi};

constexpr double inlier_px{1};
constexpr std::size_t samples_min{100};

/// Disparity at a pixel, relative to the principal point.
struct Sample {
  double u, v, disparity_px;
};

/// Plane of disparities d = n · (u, v, f), in px.
using DisparityPlane = cv::Vec3d;

double residual_px(const DisparityPlane& plane, const Sample& sample, double focal_px) {
  return std::abs(plane.dot({sample.u, sample.v, focal_px}) - sample.disparity_px);
}

std::optional<DisparityPlane> plane_through(const std::array<Sample, 3>& samples, double focal_px) {
  cv::Matx33d rows;
  cv::Vec3d disparities;
  for (int i{0}; i < 3; ++i) {
    const Sample& s{samples[static_cast<std::size_t>(i)]};
    rows(i, 0) = s.u;
    rows(i, 1) = s.v;
    rows(i, 2) = focal_px;
    disparities[i] = s.disparity_px;
  }
  if (std::abs(cv::determinant(rows)) < 1) return std::nullopt;
  return DisparityPlane{rows.inv() * disparities};
}

/// Least squares over the samples that lie on the plane.
DisparityPlane refined(const DisparityPlane& plane, const std::vector<Sample>& samples, double focal_px) {
  cv::Matx33d matrix{cv::Matx33d::zeros()};
  cv::Vec3d vector;
  for (const Sample& s : samples) {
    if (residual_px(plane, s, focal_px) >= inlier_px) continue;
    const cv::Vec3d row{s.u, s.v, focal_px};
    matrix += row * row.t();
    vector += s.disparity_px * row;
  }
  return std::abs(cv::determinant(matrix)) < 1 ? plane : DisparityPlane{matrix.inv() * vector};
}

/// Plane with most samples (RANSAC), and their share.
std::pair<DisparityPlane, double> main_plane(const std::vector<Sample>& samples, double focal_px) {
  constexpr int draws{300};
  std::pair<DisparityPlane, double> best;
  std::uint32_t state{1};
  const auto draw = [&] {
    state = state * 1664525U + 1013904223U;
    return samples[(state >> 8) % samples.size()];
  };
  for (int i{0}; i < draws; ++i) {
    const auto plane{plane_through({draw(), draw(), draw()}, focal_px)};
    if (!plane) continue;
    std::size_t on{0};
    for (const Sample& sample : samples) on += residual_px(*plane, sample, focal_px) < inlier_px ? 1 : 0;
    const double share{static_cast<double>(on) / static_cast<double>(samples.size())};
    if (share > best.second) best = {*plane, share};
  }
  for (int round{0}; round < 3; ++round) best.first = refined(best.first, samples, focal_px);
  return best;
}

std::vector<Sample> samples_of(const Image<float>& disparity, const Rig& rig) {
  constexpr int every_px{4};
  std::vector<Sample> samples;
  for (int v{0}; v < disparity.height(); v += every_px) {
    for (int u{0}; u < disparity.width(); u += every_px) {
      const double d{static_cast<double>(disparity(u, v))};
      if (d > 0) samples.push_back({u - rig.cx_px, v - rig.cy_px, d});
    }
  }
  return samples;
}

/// Share of the samples on their main plane, to a part of their disparity.
double share_on_plane(const std::vector<Sample>& samples, double focal_px) {
  constexpr double tolerance{0.01};
  const DisparityPlane plane{main_plane(samples, focal_px).first};
  const auto is_on = [&](const Sample& sample) {
    return residual_px(plane, sample, focal_px) < tolerance * sample.disparity_px;
  };
  return static_cast<double>(std::ranges::count_if(samples, is_on)) / static_cast<double>(samples.size());
}

}  // namespace

std::optional<std::string> fault_of_view(const StereoFrame& frame, const TallyContext& context) {
  constexpr double fewest_share{0.6};
  constexpr double steepest_deg{45};  // supported by calibrations and the search
  constexpr double highest_m{4.5};    // supported by the search
  constexpr double like_a_wall_deg{75};
  const bool is_external{!frame.disparity.empty()};
  Pipeline pipeline{context.config, context.source_rig};
  const FrameResult& result{pipeline.process(frame)};
  const Rig& rig{is_external ? context.source_rig : result.level_rig};
  const std::vector<Sample> samples{samples_of(is_external ? frame.disparity : result.stages.obstacle_disparity, rig)};
  if (samples.size() < samples_min) return std::nullopt;
  const auto [plane, share]{main_plane(samples, rig.focal_px)};
  const double length{cv::norm(plane)};
  const double height_m{rig.baseline_m / length};
  const double turned_rad{result.rig.camera_pitch_rad - rig.camera_pitch_rad};
  const double pitch_rad{std::atan2(plane[2], std::hypot(plane[0], plane[1])) + turned_rad};
  const double pitch_deg{pitch_rad * degrees_per_rad};
  if (share < fewest_share || plane[1] < -0.1 * length) return std::nullopt;
  const std::string seen{
      fmt::format("one plane fills the view, like the ground {:.2f} m below a camera pitched down by {:.0f}°. ",
                  height_m, pitch_deg)};
  if (pitch_deg > steepest_deg) {
    return seen + "Pitches are supported up to 45°: mount it flatter." +
           (pitch_deg > like_a_wall_deg ? " If it is a wall, the ground must be in view, too." : "");
  }
  if (context.input.extrinsics_given || height_m <= highest_m) return std::nullopt;
  return seen + fmt::format(
                    "Extrinsics are estimated up to 4.5 m above the ground: give mount: {{camera_height_m: "
                    "{:.2f}, camera_pitch_rad: {:.3f}}} in the calibration.",
                    height_m, pitch_rad);
}

std::optional<std::string> fault_of_distances(const StereoFrame& frame, const TallyContext& context) {
  constexpr double clearly{1.5};
  constexpr double fewest_share{0.2};
  const io::Recording* const recording{context.input.recording};
  if (frame.disparity.empty() || recording == nullptr || !recording->contents().has_depth) return std::nullopt;
  const Rig& rig{context.source_rig};
  const std::vector<Sample> samples{samples_of(frame.disparity, rig)};
  if (samples.size() < samples_min) return std::nullopt;
  std::vector<Sample> as_distances{samples};
  for (Sample& s : as_distances) s.disparity_px *= std::hypot(s.u, s.v, rig.focal_px) / rig.focal_px;
  const double as_depths{share_on_plane(samples, rig.focal_px)};
  const double share{share_on_plane(as_distances, rig.focal_px)};
  if (share < fewest_share || share < clearly * as_depths) return std::nullopt;
  return fmt::format(
      "the depths seem to be distances from the camera's centre: as such {:.0f} % of them lie on a plane, as depths "
      "along the optical axis {:.0f} %. Multiply each pixel by f / sqrt(f² + (u − cx)² + (v − cy)²), or record depths.",
      100 * share, 100 * as_depths);
}

}  // namespace stereogrid::app
