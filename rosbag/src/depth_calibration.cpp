// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera_infos.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/rosbag/depth.hpp"

namespace stereogrid::rosbag {
namespace {

using messages::sensor_msgs::CameraInfo;

/// CameraInfo beside the images, else beside their depth, else the bag's only one.
NamedInfo image_info_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics) {
  const std::vector<std::string> there{info_topics(bag)};
  const std::string own{info_topic_of(*find_topic(bag.topics(), topics.left), there)};
  const std::string of_depth{info_topic_of(*find_topic(bag.topics(), topics.right), there)};
  for (const std::string& topic : {own, of_depth}) {
    if (std::ranges::find(there, topic) != there.end()) return info_of(bag, name, topic);
  }
  if (there.size() == 1) return info_of(bag, name, there.front());
  fail(named(name, own), fmt::format("there is no CameraInfo for {}.", io::printable(topics.left)));
}

double focal_of(const CameraInfo& info) {
  return info.k[0] != 0 ? info.k[0] : info.p[0];
}

/// Depth of another camera than that of the images would lie beside what they show.
void check_aligned(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics, const NamedInfo& images) {
  const std::vector<std::string> there{info_topics(bag)};
  const std::string topic{info_topic_of(*find_topic(bag.topics(), topics.right), there)};
  if (topics.second != SecondTopic::depth || std::ranges::find(there, topic) == there.end()) return;
  const NamedInfo depth{info_of(bag, name, topic)};
  if (focal_of(depth.message) == 0 || depth.message.width == 0 || images.message.width == 0) return;
  const double of_depth{focal_of(depth.message) / depth.message.width};
  const double of_images{focal_of(images.message) / images.message.width};
  constexpr double most_apart{0.02};
  if (std::abs(of_depth - of_images) <= most_apart * of_images) return;
  fail(depth,
       fmt::format("depth is of another camera than {}: its focal length is {:.3f} of the width, that of the images "
                   "{:.3f}.",
                   io::printable(topics.left), of_depth, of_images),
       "Record depth that is aligned to the images (aligned_depth_to_color), or the images of the depth camera "
       "(infra1). ");
}

/// Of the first DisparityImage, or of the right camera's CameraInfo, m; 0: unknown.
double baseline_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics, const NamedInfo& left) {
  if (topics.second == SecondTopic::disparity) return first_baseline_m(bag, topics.right);
  const std::vector<std::string> there{info_topics(bag)};
  const std::string right{right_name_of(left.topic)};
  if (right.empty() || std::ranges::find(there, right) == there.end()) return 0;
  const CameraInfo info{info_of(bag, name, right).message};
  const double shift_m{info.p[0] > 0 ? -info.p[3] / info.p[0] : 0};
  return std::isfinite(shift_m) && shift_m > 0 ? shift_m : 0;
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

io::Calibration depth_calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                     int width_px, int height_px) {
  NamedInfo left{image_info_of(bag, name, topics)};
  check_aligned(bag, name, topics, left);
  const double known_m{baseline_of(bag, name, topics, left)};
  crop(left, width_px, height_px);
  const auto& d{left.message.d};
  const auto& k{left.message.k};
  const bool is_straight{std::abs(k[0] - k[4]) <= 0.01 * k[0] &&
                         std::ranges::all_of(d, [](double number) { return number == 0; })};
  const bool is_named{is_rectified(*find_topic(bag.topics(), topics.left))};
  const io::RosCamera camera{projection_of(left, is_named || left.message.k[0] == 0)};
  const double focal_px{camera.p[0] * width_px / camera.width_px};
  io::RosCamera right{camera};
  const double virtual_m{io::virtual_baseline_m(focal_px, width_px)};
  const bool is_virtual{known_m == 0 || (topics.second == SecondTopic::depth && known_m < virtual_m)};
  right.p[3] = -camera.p[0] * (is_virtual ? virtual_m : known_m);
  io::Calibration calibration{io::ros_calibration(camera, right, is_named || is_straight || left.message.k[0] == 0)};
  if (calibration.raw && topics.second == SecondTopic::disparity) {
    fail(left,
         fmt::format("{} is of rectified images, but {} are raw.", io::printable(topics.right),
                     io::printable(topics.left)),
         "Record the rectified images (image_rect). ");
  }
  io::fit_to_images(calibration, left.name, width_px, height_px);
  calibration.kind = fmt::format("CameraInfo of {}", left.topic);
  if (is_virtual) {
    calibration.notes.push_back(
        fmt::format("baseline: {}; depth becomes disparities of a virtual one of {:.4g} m",
                    known_m == 0 ? "the bag has none" : fmt::format("{:.4g} m would resolve depth coarsely", known_m),
                    calibration.rig.baseline_m));
  }
  return calibration;
}

}  // namespace stereogrid::rosbag
