// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/rosbag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "search.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"

namespace stereogrid::rosbag {
namespace {

using messages::sensor_msgs::CameraInfo;

constexpr const char* give_file{"Give a calibration.yaml with --calibration FILE (docs/input.md)."};

struct InfoPair {
  NamedInfo left;
  NamedInfo right;
};

/// Calls `take` with every message that can be decoded, until it returns false. True: there is one.
template <class Take>
bool for_each_info(const mcap::Bag& bag, const std::string& topic, Take&& take) {
  const auto cursor{bag.messages({.topics = {topic}})};
  bool found{false};
  while (const mcap::Message* const message{cursor->next()}) {
    CameraInfo info;
    try {
      messages::decode(message->data, info);
    } catch (const InputError&) {
      continue;
    }
    found = true;
    if (!take(info)) break;
  }
  return found;
}

/// `topic` has the messages of both cameras. `missing`: the right camera's own topic; empty: both have the same.
InfoPair shared_infos(const mcap::Bag& bag, const std::string& name, const std::string& topic,
                      const ImageTopics& images, const std::string& missing) {
  std::vector<CameraInfo> cameras;
  const NamedInfo info{named(name, topic)};
  const auto take = [&](const CameraInfo& message) {
    add_camera(cameras, message);
    return true;
  };
  if (!for_each_info(bag, topic, take)) fail(info, "no message can be decoded.");
  if (cameras.size() != 2) {
    fail(info,
         fmt::format("has the CameraInfo of {}, but {} and {} are images of two{}.",
                     cameras.size() == 1 ? "one camera" : "more than two cameras", images.left, images.right,
                     missing.empty() ? "" : "; " + missing + " is missing"),
         "Record one CameraInfo topic per camera, beside its images. ");
  }
  return {{cameras[0], info.name + ", left camera", info.topic},
          {cameras[1], info.name + ", right camera", info.topic}};
}

InfoPair infos_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& images) {
  const std::vector<std::string> there{info_topics(bag)};
  if (images.is_one_topic()) {
    for (const std::string& topic : there) {
      const std::string other{right_name_of(topic, there)};
      if (other.empty()) continue;
      return {info_of(bag, name, topic), info_of(bag, name, other)};
    }
  }
  const auto own = [&](const std::string& topic) { return info_topic_of(*find_topic(bag.topics(), topic), there); };
  const auto has = [&](const std::string& topic) { return std::ranges::find(there, topic) != there.end(); };
  const std::string left{own(images.left)};
  const std::string right{own(images.right)};
  if (left != right && has(left) && has(right)) return {info_of(bag, name, left), info_of(bag, name, right)};
  if (left == right && has(left)) return shared_infos(bag, name, left, images, "");
  const std::string& missing{has(left) ? right : left};
  if (there.size() == 1) return shared_infos(bag, name, there.front(), images, missing);
  std::string list;
  for (const std::string& topic : there) list += (list.empty() ? " CameraInfo is on " : ", ") + io::printable(topic);
  fail(named(name, missing), fmt::format("there is no CameraInfo for {}.{}", has(left) ? images.right : images.left,
                                         list.empty() ? list : list + "."));
}

/// Baseline between the frames of both CameraInfo, where they have none: drivers publish it on /tf_static alone.
/// Empty: nothing to say.
std::string set_baseline_of_tf(const mcap::Bag& bag, InfoPair& infos) {
  CameraInfo& left{infos.left.message};
  CameraInfo& right{infos.right.message};
  const bool has_baseline{left.p[3] < right.p[3] || left.p[3] > right.p[3]};
  if (has_baseline || left.header.frame_id == right.header.frame_id) return {};
  TransformBuffer transforms;
  add_static_transforms(transforms, bag);
  constexpr std::chrono::milliseconds at_once{0};
  if (!transforms.are_connected(left.header.frame_id, right.header.frame_id, at_once)) return {};
  const cv::Affine3d left_from_right{transforms.newest(left.header.frame_id, right.header.frame_id, at_once)};
  const cv::Vec3d shift_m{left_from_right.translation()};
  const bool is_body{std::abs(shift_m[1]) > std::abs(shift_m[0])};  // x ahead, y to the left
  const double baseline_m{is_body ? -shift_m[1] : shift_m[0]};
  constexpr double parallel_rad{0.02};
  if (!(baseline_m > 0) || cv::norm(left_from_right.rvec()) > parallel_rad) return {};
  right.p[3] = left.p[3] - right.p[0] * baseline_m;
  return fmt::format("baseline: {:.4g} m from {} to {} on /tf_static; Tx of both CameraInfo is equal", baseline_m,
                     io::printable(left.header.frame_id, 60), io::printable(right.header.frame_id, 60));
}

}  // namespace

void fail(const NamedInfo& info, const std::string& what, const std::string& mend) {
  throw InputError{info.name, what, mend + give_file};
}

std::vector<std::string> info_topics(const mcap::Bag& bag) {
  std::vector<std::string> names;
  for (const mcap::Topic& topic : bag.topics()) {
    if (topic.type == CameraInfo::type_name && topic.message_count > 0) names.push_back(topic.name);
  }
  return names;
}

NamedInfo named(const std::string& name, const std::string& topic) {
  return {{}, name + ", " + io::printable(topic), io::printable(topic)};
}

NamedInfo info_of(const mcap::Bag& bag, const std::string& name, const std::string& topic) {
  NamedInfo info{named(name, topic)};
  const auto take = [&](CameraInfo& message) {
    info.message = std::move(message);
    return false;
  };
  if (!for_each_info(bag, topic, take)) fail(info, "no message can be decoded.");
  return info;
}

void crop(NamedInfo& info, int width_px, int height_px) {
  CameraInfo& message{info.message};
  const auto roi{message.roi};
  const bool is_whole{roi.x_offset == 0 && roi.y_offset == 0 && roi.width == 0 && roi.height == 0};
  if (is_whole) return;
  const std::uint32_t width{roi.width == 0 ? message.width : roi.width};
  const std::uint32_t height{roi.height == 0 ? message.height : roi.height};
  const auto fits = [&](std::uint32_t size_px, std::uint32_t binning, int image_px) {
    return size_px / std::max(1U, binning) == static_cast<std::uint32_t>(image_px);
  };
  const bool is_of_roi{fits(width, message.binning_x, width_px) && fits(height, message.binning_y, height_px)};
  const bool is_of_all{fits(message.width, message.binning_x, width_px) &&
                       fits(message.height, message.binning_y, height_px)};
  if (!is_of_roi && is_of_all) return;  // a region that is not applied
  if (!is_of_roi) {
    fail(info,
         fmt::format("the region of interest of {}×{} px, binning {}×{}, is not that of the images of {}×{} px.", width,
                     height, std::max(1U, message.binning_x), std::max(1U, message.binning_y), width_px, height_px));
  }
  message.width = width;
  message.height = height;
  for (const std::size_t i : {2, 5}) message.k.at(i) -= message.k.at(i) == 0 ? 0 : i == 2 ? roi.x_offset : roi.y_offset;
  message.p[2] -= roi.x_offset;
  message.p[6] -= roi.y_offset;
}

io::RosCamera camera_of(const NamedInfo& info) {
  const CameraInfo& message{info.message};
  if (message.k[0] == 0 && message.p[0] == 0) fail(info, "the camera is not calibrated: K[0] and P[0] are 0.");
  if (message.width == 0 || message.height == 0 || std::max(message.width, message.height) > io::largest_side_px) {
    fail(info, fmt::format("the CameraInfo is for images of {}×{} px (allowed 1 to {}).", message.width, message.height,
                           io::largest_side_px));
  }
  io::RosCamera camera{info.name,
                       static_cast<int>(message.width),
                       static_cast<int>(message.height),
                       message.distortion_model,
                       message.d,
                       message.k,
                       message.r,
                       message.p};
  // simulators leave it out where there is none; without numbers a fisheye lens still is one
  if (camera.d.empty() && camera.distortion_model != "equidistant") {
    camera.distortion_model = "plumb_bob";
    camera.d.resize(5);
  }
  return camera;
}

void add_camera(std::vector<CameraInfo>& cameras, const CameraInfo& message) {
  constexpr std::size_t most{3};  // one more than there may be
  const auto is_same = [&](const CameraInfo& camera) {
    return camera.header.frame_id == message.header.frame_id && !(camera.p[3] < message.p[3]) &&
           !(camera.p[3] > message.p[3]);
  };
  if (cameras.size() >= most || std::ranges::any_of(cameras, is_same)) return;
  cameras.insert(std::ranges::find_if(cameras, [&](const CameraInfo& camera) { return camera.p[3] < message.p[3]; }),
                 message);
}

io::Calibration calibration_of(NamedInfo left, NamedInfo right, bool are_rectified, int width_px, int height_px) {
  crop(left, width_px, height_px);
  crop(right, width_px, height_px);
  // cameras that rectify their images themselves leave K empty
  const bool has_projection_only{left.message.k[0] == 0 || right.message.k[0] == 0};
  io::Calibration calibration{
      io::ros_calibration(camera_of(left), camera_of(right), are_rectified || has_projection_only)};
  if (has_projection_only && !are_rectified) {
    calibration.notes.emplace_back("images: K is zero: taken as rectified, as P describes them");
  }
  io::fit_to_images(calibration, left.name, width_px, height_px);
  calibration.kind = left.topic == right.topic ? fmt::format("CameraInfo of both cameras on {}", left.topic)
                                               : fmt::format("CameraInfo of {} and {}", left.topic, right.topic);
  return calibration;
}

io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics, int width_px,
                               int height_px) {
  if (topics.has_depth()) return depth_calibration_of(bag, name, topics, width_px, height_px);
  const bool are_rectified{is_rectified(*find_topic(bag.topics(), topics.left)) &&
                           is_rectified(*find_topic(bag.topics(), topics.right))};
  InfoPair infos{infos_of(bag, name, topics)};
  const std::string note{set_baseline_of_tf(bag, infos)};
  io::Calibration calibration{calibration_of(infos.left, infos.right, are_rectified, width_px, height_px)};
  if (!note.empty()) calibration.notes.push_back(note);
  return calibration;
}

}  // namespace stereogrid::rosbag
