// SPDX-License-Identifier: Apache-2.0
#include "landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "stereogrid/exposure.hpp"

namespace stereogrid {
namespace {

const cv::Size flow_window{11, 11};
constexpr int flow_levels{3};
constexpr int cells_across{12};
constexpr int cells_down{4};
constexpr int corners_per_cell{14};
constexpr double corner_quality{0.02};
constexpr double corner_distance_px{7};
constexpr float home_px{0.5F};  // maximum distance between the start of a point and its end after tracking forward and
                                // backward
// Maximum row difference between left and right. Above the first limit the columns are wrong, too (measured on KITTI,
// docs/concepts.md); such points are used only if most of the image is like that.
constexpr float good_row_difference_px{0.6F};
constexpr float row_difference_max_px{2.5F};
constexpr float disparity_min_px{1};
constexpr int coarse_px{4};  // reduction factor of the first disparity search
constexpr int coarse_window_px{9};

cv::Mat mat_of(const Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
}

// Each cell has its own scale of quality: a bright sign must not be all that is seen.
std::vector<cv::Point2f> find_corners(const cv::Mat& image, const cv::Mat& mask) {
  std::vector<cv::Point2f> all;
  for (int j{0}; j < cells_down; ++j) {
    for (int i{0}; i < cells_across; ++i) {
      const cv::Point start{image.cols * i / cells_across, image.rows * j / cells_down};
      const cv::Point end{image.cols * (i + 1) / cells_across, image.rows * (j + 1) / cells_down};
      if (end.x <= start.x || end.y <= start.y) continue;
      std::vector<cv::Point2f> corners;
      const cv::Rect cell{start, end};
      cv::goodFeaturesToTrack(image(cell), corners, corners_per_cell, corner_quality, corner_distance_px,
                              mask.empty() ? mask : mask(cell));
      for (const cv::Point2f& corner : corners) all.push_back(corner + cv::Point2f{start});
    }
  }
  return all;
}

/// Forth from `start` (`end` holds guesses) and back; true where the point came home. `levels`: of the pyramid, above
/// the image itself, for guesses that are less good.
std::vector<bool> flow(const Pyramid& from, const Pyramid& to, const std::vector<cv::Point2f>& start,
                       std::vector<cv::Point2f>& end, int levels) {
  std::vector<bool> came_home(start.size(), false);
  if (start.empty()) return came_home;
  const cv::TermCriteria until{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01};
  std::vector<unsigned char> forth;
  std::vector<unsigned char> back;
  cv::calcOpticalFlowPyrLK(from, to, start, end, forth, cv::noArray(), flow_window, levels, until,
                           cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
  std::vector<cv::Point2f> home{start};
  cv::calcOpticalFlowPyrLK(to, from, end, home, back, cv::noArray(), flow_window, 0, until,
                           cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
  const cv::Rect2f inside{0, 0, static_cast<float>(to[0].cols - 1), static_cast<float>(to[0].rows - 1)};
  for (std::size_t i{0}; i < start.size(); ++i) {
    came_home[i] = forth[i] != 0 && back[i] != 0 && inside.contains(end[i]) && cv::norm(home[i] - start[i]) < home_px;
  }
  return came_home;
}

GreyCounts counts_of(const Image<std::uint8_t>& image) {
  GreyCounts counts{};
  for (const std::uint8_t grey : image) ++counts[grey];
  return counts;
}

/// Right image; with unequal exposures it gets the grey levels of the left one, as tracking assumes equal grey levels.
Image<std::uint8_t> right_as_left(const StereoFrame& frame) {
  Image<std::uint8_t> right{frame.right};
  const GreyCounts left_counts{counts_of(frame.left)};
  const GreyCounts right_counts{counts_of(frame.right)};
  if (!is_unequal(exposure_of(left_counts, right_counts))) return right;
  const GreyTransfer left_of_right{transfer_of(right_counts, left_counts)};
  for (std::uint8_t& grey : right) grey = left_of_right[grey];
  return right;
}

/// To begin with, 0 where unknown: block matching at a quarter of the size.
std::vector<float> coarse_disparities(const Image<std::uint8_t>& left_image, const Image<std::uint8_t>& right_image,
                                      const std::vector<cv::Point2f>& corners) {
  std::vector<float> found(corners.size(), 0.0F);
  const int disparities{std::max(16, (left_image.width() / 8 / coarse_px + 15) / 16 * 16)};
  if (left_image.width() / coarse_px <= disparities + coarse_window_px ||
      left_image.height() / coarse_px <= coarse_window_px) {
    return found;
  }
  cv::Mat left;
  cv::Mat right;
  cv::resize(mat_of(left_image), left, {}, 1.0 / coarse_px, 1.0 / coarse_px, cv::INTER_AREA);
  cv::resize(mat_of(right_image), right, {}, 1.0 / coarse_px, 1.0 / coarse_px, cv::INTER_AREA);
  cv::Mat sixteenths;
  const auto matcher{cv::StereoBM::create(disparities, coarse_window_px)};
  matcher->compute(left, right, sixteenths);
  for (std::size_t i{0}; i < corners.size(); ++i) {
    const int u{std::min(static_cast<int>(corners[i].x / coarse_px), left.cols - 1)};
    const int v{std::min(static_cast<int>(corners[i].y / coarse_px), left.rows - 1)};
    found[i] = std::max(0.0F, static_cast<float>(sixteenths.at<std::int16_t>(v, u)) / 16 * coarse_px);
  }
  return found;
}

/// Finds the corners in the right image. The search starts at a rough disparity if there is one, else at infinity.
std::vector<bool> find_in_right(const StereoFrame& frame, const Pyramid& left, const std::vector<cv::Point2f>& corners,
                                std::vector<cv::Point2f>& in_right) {
  const Image<std::uint8_t> right_image{right_as_left(frame)};
  const Pyramid right{pyramid_of(right_image)};
  const std::vector<float> coarse{coarse_disparities(frame.left, right_image, corners)};
  std::vector<bool> found(corners.size(), false);
  in_right.resize(corners.size());
  for (const bool are_known : {true, false}) {
    std::vector<std::size_t> places;
    std::vector<cv::Point2f> start;
    std::vector<cv::Point2f> end;
    for (std::size_t i{0}; i < corners.size(); ++i) {
      if ((coarse[i] > 0) != are_known) continue;
      places.push_back(i);
      start.push_back(corners[i]);
      end.push_back(corners[i] - cv::Point2f{coarse[i], 0});
    }
    const std::vector<bool> matched{flow(left, right, start, end, are_known ? 0 : flow_levels)};
    for (std::size_t k{0}; k < places.size(); ++k) {
      in_right[places[k]] = end[k];
      found[places[k]] = matched[k];
    }
  }
  return found;
}

float row_limit_px(const std::vector<cv::Point2f>& left, const std::vector<cv::Point2f>& right,
                   const std::vector<bool>& matched) {
  std::vector<float> differences;
  for (std::size_t i{0}; i < left.size(); ++i) {
    if (matched[i]) differences.push_back(std::abs(left[i].y - right[i].y));
  }
  if (differences.empty()) return 0;
  const auto middle{differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2)};
  std::nth_element(differences.begin(), middle, differences.end());
  return std::clamp(*middle, good_row_difference_px, row_difference_max_px);
}

/// Disparities of the corners, px; 0: none.
std::vector<float> disparities_of(const StereoFrame& frame, const Pyramid& left,
                                  const std::vector<cv::Point2f>& corners) {
  std::vector<float> disparities(corners.size(), 0.0F);
  if (frame.right.empty()) {
    for (std::size_t i{0}; i < corners.size(); ++i) {
      const float given{frame.disparity(static_cast<int>(corners[i].x), static_cast<int>(corners[i].y))};
      disparities[i] = std::isfinite(given) ? given : 0;
    }
    return disparities;
  }
  std::vector<cv::Point2f> in_right;
  const std::vector<bool> matched{find_in_right(frame, left, corners, in_right)};
  const float limit_px{row_limit_px(corners, in_right, matched)};
  for (std::size_t i{0}; i < corners.size(); ++i) {
    const cv::Point2f shift{corners[i] - in_right[i]};
    if (matched[i] && std::abs(shift.y) <= limit_px) disparities[i] = shift.x;
  }
  return disparities;
}

}  // namespace

Pyramid pyramid_of(const Image<std::uint8_t>& image) {
  Pyramid pyramid;
  cv::buildOpticalFlowPyramid(mat_of(image), pyramid, flow_window, flow_levels, false, cv::BORDER_REFLECT_101,
                              cv::BORDER_CONSTANT, false);
  return pyramid;
}

namespace {

/// The mask without pixels that are labelled to be ignored or as movers. Empty: all pixels are used.
cv::Mat used_pixels(const Image<std::uint8_t>& mask, const Image<std::uint8_t>& labels) {
  if (labels.empty()) return mask.empty() ? cv::Mat{} : mat_of(mask);
  const cv::Mat label{mat_of(labels)};
  cv::Mat used{(label != static_cast<int>(PixelLabel::ignore)) & (label != static_cast<int>(PixelLabel::mover))};
  return mask.empty() ? used : cv::Mat{used & (mat_of(mask) != 0)};
}

}  // namespace

Landmarks find_landmarks(const StereoFrame& frame, const Pyramid& left, const Rig& rig,
                         const Image<std::uint8_t>& mask) {
  const std::vector<cv::Point2f> corners{find_corners(mat_of(frame.left), used_pixels(mask, frame.labels))};
  const std::vector<float> disparities{disparities_of(frame, left, corners)};
  Landmarks landmarks;
  for (std::size_t i{0}; i < corners.size(); ++i) {
    if (disparities[i] < disparity_min_px) continue;
    const double depth_m{rig.focal_px * rig.baseline_m / disparities[i]};
    landmarks.at_px.push_back(corners[i]);
    landmarks.in_camera.emplace_back((corners[i].x - rig.cx_px) * depth_m / rig.focal_px,
                                     (corners[i].y - rig.cy_px) * depth_m / rig.focal_px, depth_m);
  }
  return landmarks;
}

Tracks follow(const Landmarks& landmarks, const Pyramid& reference, const Pyramid& now,
              const cv::Affine3d& now_from_reference, const Rig& rig) {
  std::vector<cv::Point2f> guess{landmarks.at_px};
  for (std::size_t i{0}; i < guess.size(); ++i) {
    const cv::Point3f& p{landmarks.in_camera[i]};
    const double depth_m{(now_from_reference * cv::Vec3d{p.x, p.y, p.z})[2]};
    if (depth_m > 0.5) guess[i] = project(now_from_reference, p, rig);
  }
  const std::vector<bool> followed{flow(reference, now, landmarks.at_px, guess, flow_levels)};
  Tracks tracks;
  for (std::size_t i{0}; i < guess.size(); ++i) {
    if (!followed[i]) continue;
    tracks.landmark.push_back(static_cast<int>(i));
    tracks.at_px.push_back(guess[i]);
  }
  return tracks;
}

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

cv::Matx66d covariance_of(const cv::Affine3d& now_from_reference, const std::vector<int>& inliers,
                          const Landmarks& landmarks, const Tracks& tracks, const Rig& rig) {
  constexpr double parameters{6};
  cv::Matx66d normal{cv::Matx66d::zeros()};
  double squares_px2{0};
  for (const int place : inliers) {
    const auto i{static_cast<std::size_t>(place)};
    const cv::Point3f& point{landmarks.in_camera[static_cast<std::size_t>(tracks.landmark[i])]};
    const cv::Vec3d p{now_from_reference * cv::Vec3d{point.x, point.y, point.z}};
    if (p[2] <= 0) continue;  // passed
    const double x{p[0] / p[2]};
    const double y{p[1] / p[2]};
    const double f{rig.focal_px};
    const double g{rig.focal_px / p[2]};
    const cv::Matx<double, 2, 6> derivative{-f * x * y,       f * (1 + x * x), -f * y, g, 0, -g * x,
                                            -f * (1 + y * y), f * x * y,       f * x,  0, g, -g * y};
    normal += derivative.t() * derivative;
    const cv::Point2d residual_px{project(now_from_reference, point, rig) - cv::Point2d{tracks.at_px[i]}};
    squares_px2 += residual_px.dot(residual_px);
  }
  const double freedom{2 * static_cast<double>(inliers.size()) - parameters};
  return normal.inv(cv::DECOMP_CHOLESKY) * (squares_px2 / freedom);
}

}  // namespace stereogrid
