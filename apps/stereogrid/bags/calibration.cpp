// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "bags/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "stereogrid/error.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::app {
namespace {

using messages::sensor_msgs::CameraInfo;

constexpr const char* give_file{"Give a calibration.yaml with --calibration FILE (docs/input.md)."};

/// A camera's calibration, and the topic that it came from.
struct Info {
  CameraInfo message;
  std::string topic;

  [[noreturn]] void fail(const std::string& bag, const std::string& what) const {
    throw InputError{bag + ", " + io::printable(topic), what, give_file};
  }
};

Info info_of(const mcap::Bag& bag, const std::string& name, const std::string& images) {
  Info info{{}, info_topic_of(*find_topic(bag.topics(), images))};
  const mcap::Topic* const topic{find_topic(bag.topics(), info.topic)};
  if (topic == nullptr || topic->type != CameraInfo::type_name) {
    info.fail(name, fmt::format("there is no CameraInfo for {}.", io::printable(images)));
  }
  const auto cursor{bag.messages({.topics = {info.topic}})};
  const mcap::Message* const first{cursor->next()};
  if (first == nullptr) info.fail(name, "no message can be read.");
  messages::decode(first->data, info.message);
  return info;
}

bool all_finite(const CameraInfo& info) {
  const auto finite = [](double number) { return std::isfinite(number); };
  return std::ranges::all_of(info.k, finite) && std::ranges::all_of(info.d, finite) &&
         std::ranges::all_of(info.r, finite) && std::ranges::all_of(info.p, finite);
}

void check(const Info& info, const std::string& bag, int width_px, int height_px) {
  const CameraInfo& message{info.message};
  if (!all_finite(message)) info.fail(bag, "the CameraInfo has numbers that are none.");
  if (message.k[0] == 0 || message.k[4] == 0) info.fail(bag, "the camera is not calibrated: K[0] is 0.");
  if (message.k[0] < 1 || message.k[4] < 1) info.fail(bag, "the focal length (K[0], K[4]) is below one pixel.");
  const std::uint32_t width{message.width};
  const std::uint32_t height{message.height};
  if (message.binning_x > 1 || message.binning_y > 1 || message.roi.x_offset != 0 || message.roi.y_offset != 0) {
    info.fail(bag, "the images are a part of the camera's (binning, roi), which is not read.");
  }
  if (width != static_cast<std::uint32_t>(width_px) || height != static_cast<std::uint32_t>(height_px)) {
    info.fail(bag, fmt::format("the CameraInfo is for {}×{} px, but the images have {}×{}.", width, height, width_px,
                               height_px));
  }
}

bool is_identity(const std::array<double, 9>& r) {
  constexpr std::array<double, 9> identity{1, 0, 0, 0, 1, 0, 0, 0, 1};
  return std::ranges::equal(r, identity, [](double a, double b) { return std::abs(a - b) < 1e-9; });
}

/// Nothing is left to do.
bool is_ideal(const CameraInfo& info) {
  return std::ranges::all_of(info.d, [](double number) { return number == 0; }) && is_identity(info.r);
}

double baseline_of(const Info& left, const Info& right, const std::string& bag) {
  const auto& p{right.message.p};
  if (p[0] <= 0) right.fail(bag, "P[0] is not positive: the pair is not calibrated as one.");
  const double baseline_m{(left.message.p[3] - p[3]) / p[0]};
  if (baseline_m == 0) right.fail(bag, "the baseline is 0: P[3] of the right camera is −focal length · baseline.");
  if (baseline_m < 0)
    right.fail(bag, "the baseline is negative: left and right are swapped, or P[3] has a wrong sign.");
  return baseline_m;
}

Rig rectified_rig(const Info& left, const Info& right, const std::string& bag) {
  const auto& l{left.message.p};
  const auto& r{right.message.p};
  constexpr double same_px{0.01};
  Rig rig;
  rig.baseline_m = baseline_of(left, right, bag);
  if (std::abs(l[0] - r[0]) > same_px || std::abs(l[2] - r[2]) > same_px || std::abs(l[6] - r[6]) > same_px ||
      std::abs(l[0] - l[5]) > same_px) {
    right.fail(bag, "P of both cameras do not have the same focal length and centre, as those of a rectified pair do.");
  }
  rig.focal_px = l[0];
  rig.centre_u_px = l[2];
  rig.centre_v_px = l[6];
  return rig;
}

io::CameraModel model_of(const Info& info, const std::string& bag) {
  const CameraInfo& message{info.message};
  const std::size_t count{message.d.size()};
  const bool is_read{message.distortion_model.empty() || message.distortion_model == "plumb_bob" ||
                     message.distortion_model == "rational_polynomial"};
  if (!is_read || (count != 0 && count != 4 && count != 5 && count != 8)) {
    info.fail(bag, fmt::format("the distortion model \"{}\" with {} numbers is not read: plumb_bob and "
                               "rational_polynomial are.",
                               io::printable(message.distortion_model), count));
  }
  return {message.k[0], message.k[4], message.k[2], message.k[5], message.d};
}

/// R turns each camera into the rectified pair, whose right camera stands a baseline beside the left one.
io::RawPair raw_pair(const Info& left, const Info& right, const std::string& bag) {
  const cv::Matx33d rectified_from_left{left.message.r.data()};
  const cv::Matx33d rectified_from_right{right.message.r.data()};
  for (const Info* const info : {&left, &right}) {
    const cv::Matx33d r{info->message.r.data()};
    if (cv::norm(r * r.t() - cv::Matx33d::eye(), cv::NORM_INF) > 0.01 || cv::determinant(r) < 0) {
      info->fail(bag, "R is no rotation.");
    }
  }
  const cv::Matx33d rotation{rectified_from_right.t() * rectified_from_left};
  const cv::Vec3d translation{rectified_from_right.t() * cv::Vec3d{-baseline_of(left, right, bag), 0, 0}};
  io::RawPair raw{model_of(left, bag), model_of(right, bag), {}, {}};
  std::copy_n(rotation.val, 9, raw.right_from_left_rotation.begin());
  std::copy_n(translation.val, 3, raw.right_from_left_translation_m.begin());
  return raw;
}

}  // namespace

io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics, int width_px,
                               int height_px) {
  const Info left{info_of(bag, name, topics.left)};
  const Info right{info_of(bag, name, topics.right)};
  check(left, name, width_px, height_px);
  check(right, name, width_px, height_px);
  io::Calibration calibration;
  calibration.kind = fmt::format("CameraInfo of {} and {}", io::printable(left.topic), io::printable(right.topic));
  const bool says_so{is_rectified(*find_topic(bag.topics(), topics.left)) &&
                     is_rectified(*find_topic(bag.topics(), topics.right))};
  if (says_so || (is_ideal(left.message) && is_ideal(right.message))) {
    calibration.rig = rectified_rig(left, right, name);
    calibration.rig.width_px = width_px;
    calibration.rig.height_px = height_px;
  } else {
    calibration.raw = raw_pair(left, right, name);
    calibration.rig = io::Rectifier{*calibration.raw, width_px, height_px}.rig();
  }
  if (const auto found{problems(calibration.rig)}; !found.empty()) right.fail(name, found.front());
  return calibration;
}

}  // namespace stereogrid::app
