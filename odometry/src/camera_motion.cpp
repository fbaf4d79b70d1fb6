// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "landmarks.hpp"

#include <opencv2/calib3d.hpp>

namespace stereogrid {
namespace {

constexpr std::size_t inliers_min{15};
constexpr double share_min{0.15};  // share of the tracked points
constexpr float ransac_px{1.5F};
constexpr double inlier_px{1.0};
constexpr double near_expected_px{3};
constexpr int ransac_rounds{200};

struct Camera {
  explicit Camera(const Rig& rig) : matrix{rig.focal_px, 0, rig.cx_px, 0, rig.focal_px, rig.cy_px, 0, 0, 1} {}
  cv::Matx33d matrix;
};

struct Pairs {
  std::vector<cv::Point3f> in_camera;
  std::vector<cv::Point2f> at_px;
};

Pairs pairs_of(const Landmarks& landmarks, const Tracks& tracks, const std::vector<int>& places) {
  Pairs pairs;
  for (const int place : places) {
    const auto i{static_cast<std::size_t>(place)};
    pairs.in_camera.push_back(landmarks.in_camera[static_cast<std::size_t>(tracks.landmark[i])]);
    pairs.at_px.push_back(tracks.at_px[i]);
  }
  return pairs;
}

std::vector<int> inliers_of(const cv::Affine3d& now_from_reference, const Landmarks& landmarks, const Tracks& tracks,
                            const Rig& rig, double within_px) {
  std::vector<int> inliers;
  for (std::size_t i{0}; i < tracks.at_px.size(); ++i) {
    const cv::Point3f& point{landmarks.in_camera[static_cast<std::size_t>(tracks.landmark[i])]};
    if (cv::norm(project(now_from_reference, point, rig) - cv::Point2d{tracks.at_px[i]}) < within_px) {
      inliers.push_back(static_cast<int>(i));
    }
  }
  return inliers;
}

bool are_enough(const std::vector<int>& inliers, const Tracks& tracks) {
  return inliers.size() >= inliers_min &&
         static_cast<double>(inliers.size()) >= share_min * static_cast<double>(tracks.at_px.size());
}

/// Least squares over those that agree, who may become more by it.
std::optional<MotionFit> refined(cv::Affine3d motion, double within_px, const Landmarks& landmarks,
                                 const Tracks& tracks, const Rig& rig) {
  std::vector<int> inliers{inliers_of(motion, landmarks, tracks, rig, within_px)};
  for (int round{0}; round < 3; ++round) {
    if (!are_enough(inliers, tracks)) return std::nullopt;
    const Pairs pairs{pairs_of(landmarks, tracks, inliers)};
    cv::Vec3d rotation{motion.rvec()};
    cv::Vec3d translation{motion.translation()};
    cv::solvePnPRefineLM(pairs.in_camera, pairs.at_px, Camera{rig}.matrix, cv::noArray(), rotation, translation);
    motion = cv::Affine3d{rotation, translation};
    inliers = inliers_of(motion, landmarks, tracks, rig, inlier_px);
  }
  if (!are_enough(inliers, tracks)) return std::nullopt;
  return MotionFit{motion, inliers};
}

std::optional<cv::Affine3d> most_agreed(const Landmarks& landmarks, const Tracks& tracks, const Rig& rig) {
  std::vector<int> all(tracks.at_px.size());
  for (std::size_t i{0}; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const Pairs pairs{pairs_of(landmarks, tracks, all)};
  cv::Vec3d rotation;
  cv::Vec3d translation;
  // draws from a generator of its own that begins with the same seed each time
  const bool found{cv::solvePnPRansac(pairs.in_camera, pairs.at_px, Camera{rig}.matrix, cv::noArray(), rotation,
                                      translation, false, ransac_rounds, ransac_px, 0.999, cv::noArray(),
                                      cv::SOLVEPNP_EPNP)};
  if (!found) return std::nullopt;
  return cv::Affine3d{rotation, translation};
}

}  // namespace

std::optional<MotionFit> fit_motion(const Landmarks& landmarks, const Tracks& tracks,
                                    const std::optional<cv::Affine3d>& expected, const Rig& rig,
                                    const std::function<bool(const cv::Affine3d&)>& plausible) {
  if (tracks.at_px.size() < inliers_min) return std::nullopt;
  if (const auto agreed{most_agreed(landmarks, tracks, rig)}) {
    auto fit{refined(*agreed, ransac_px, landmarks, tracks, rig)};
    if (fit && plausible(fit->now_from_reference)) return fit;
  }
  if (!expected) return std::nullopt;
  auto fit{refined(*expected, near_expected_px, landmarks, tracks, rig)};
  if (fit && plausible(fit->now_from_reference)) return fit;
  return std::nullopt;
}

}  // namespace stereogrid
