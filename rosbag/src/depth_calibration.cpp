// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "search.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/rosbag/decode.hpp"

namespace stereogrid::rosbag {
namespace {

using messages::sensor_msgs::CameraInfo;

double focal_of(const CameraInfo& info) {
  return info.k[0] != 0 ? info.k[0] : info.p[0];
}

/// Depth of another camera than that of the images would lie beside what they show.
void check_aligned(const DepthInfos& infos, const ImageTopics& topics) {
  if (topics.second != SecondTopic::depth || !infos.depth) return;
  const CameraInfo& depth{infos.depth->message};
  const CameraInfo& images{infos.images.message};
  if (focal_of(depth) == 0 || depth.width == 0 || images.width == 0) return;
  const double of_depth{focal_of(depth) / depth.width};
  const double of_images{focal_of(images) / images.width};
  constexpr double most_apart{0.02};
  if (std::abs(of_depth - of_images) <= most_apart * of_images) return;
  fail(*infos.depth,
       fmt::format("depth is of another camera than {}: its focal length is {:.3f} of the width, that of the images "
                   "{:.3f}.",
                   topics.left, of_depth, of_images),
       "Take depth that is aligned to the images (aligned_depth_to_color), or the images of the depth camera "
       "(infra1). ");
}

/// One camera as both: the pair has its optics and a baseline alone.
io::RosCamera projection_of(const NamedInfo& info, bool are_rectified) {
  io::RosCamera camera{camera_of(info)};
  const auto& k{camera.k};
  const bool is_of_k{camera.p[0] == 0 || (!are_rectified && k[0] != 0)};
  if (is_of_k) camera.p = {k[0], 0, k[2], 0, 0, k[0], k[5], 0, 0, 0, 1, 0};
  if (is_of_k || std::ranges::all_of(camera.r, [](double number) { return number == 0; })) {
    camera.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  }
  camera.p[3] = 0;
  return camera;
}

}  // namespace

DepthInfoTopics depth_info_topics(const mcap::Topic& images, const mcap::Topic& depth,
                                  const std::vector<std::string>& there) {
  const auto there_or_none = [&](std::string topic) {
    return std::ranges::find(there, topic) == there.end() ? std::string{} : topic;
  };
  DepthInfoTopics found{there_or_none(info_topic_of(images, there)), there_or_none(info_topic_of(depth, there)), ""};
  if (found.images.empty()) found.images = found.depth;
  if (found.images.empty() && there.size() == 1) found.images = there.front();
  found.right = there_or_none(right_name_of(found.images));
  return found;
}

double baseline_m_of(const CameraInfo& right) {
  const double shift_m{right.p[0] > 0 ? -right.p[3] / right.p[0] : 0};
  return std::isfinite(shift_m) && shift_m > 0 ? shift_m : 0;
}

io::Calibration calibration_of(DepthInfos infos, const mcap::Topic& images, const ImageTopics& topics, int width_px,
                               int height_px) {
  check_aligned(infos, topics);
  NamedInfo& left{infos.images};
  const double known_m{infos.baseline_m};
  crop(left, width_px, height_px);
  const auto& d{left.message.d};
  const auto& k{left.message.k};
  const bool is_straight{std::abs(k[0] - k[4]) <= 0.01 * k[0] &&
                         std::ranges::all_of(d, [](double number) { return number == 0; })};
  const bool is_named{is_rectified(images)};
  const io::RosCamera camera{projection_of(left, is_named || left.message.k[0] == 0)};
  const double focal_px{camera.p[0] * width_px / camera.width_px};
  io::RosCamera right{camera};
  const double virtual_m{io::virtual_baseline_m(focal_px, width_px)};
  const bool is_virtual{known_m == 0 || (topics.second == SecondTopic::depth && known_m < virtual_m)};
  right.p[3] = -camera.p[0] * (is_virtual ? virtual_m : known_m);
  io::Calibration calibration{io::ros_calibration(camera, right, is_named || is_straight || left.message.k[0] == 0)};
  if (calibration.raw && topics.second == SecondTopic::disparity) {
    fail(left, fmt::format("{} is of rectified images, but {} are raw.", topics.right, topics.left),
         "Take the rectified images (image_rect). ");
  }
  io::fit_to_images(calibration, left.name, width_px, height_px);
  calibration.kind = fmt::format("CameraInfo of {}", left.topic);
  if (is_virtual) {
    calibration.notes.push_back(
        fmt::format("baseline: {}; depth becomes disparities of a virtual one of {:.4g} m",
                    known_m == 0 ? "none is given" : fmt::format("{:.4g} m would resolve depth coarsely", known_m),
                    calibration.rig.baseline_m));
  }
  return calibration;
}

io::Calibration depth_calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                     int width_px, int height_px) {
  const mcap::Topic& images{*find_topic(bag.topics(), topics.left)};
  const std::vector<std::string> there{info_topics(bag)};
  const DepthInfoTopics found{depth_info_topics(images, *find_topic(bag.topics(), topics.right), there)};
  if (found.images.empty()) {
    fail(named(name, info_topic_of(images, there)), fmt::format("there is no CameraInfo for {}.", topics.left));
  }
  DepthInfos infos{info_of(bag, name, found.images), std::nullopt};
  if (!found.depth.empty() && topics.second == SecondTopic::depth) infos.depth = info_of(bag, name, found.depth);
  if (topics.second == SecondTopic::disparity) {
    infos.baseline_m = first_baseline_m(bag, topics.right);
  } else if (!found.right.empty()) {
    infos.baseline_m = baseline_m_of(info_of(bag, name, found.right).message);
  }
  return calibration_of(std::move(infos), images, topics, width_px, height_px);
}

}  // namespace stereogrid::rosbag
