// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ranges>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "search.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::rosbag {
namespace {

using mcap::Topic;

constexpr std::string_view aligned{"aligned_depth_to_"};

std::string_view last_of(std::string_view name) {
  return name.substr(name.rfind('/') + 1);
}

bool is_image_message(const Topic& topic) {
  return topic.type == messages::sensor_msgs::Image::type_name || is_compressed(topic);
}

/// "depth/image_rect_raw", "aligned_depth_to_color/image_raw", "depth_registered", "stereo/depth"
bool is_depth_name(const Topic& topic) {
  const std::string base{base_of(topic)};
  const std::string parent{parent_of(base)};
  const std::string_view folder{last_of(parent)};
  if (topic.name.ends_with("/compressedDepth")) return true;
  return folder == "depth" || folder.starts_with(aligned) || folder.starts_with("depth_registered") ||
         folder.starts_with("depth_to_") || last_of(base).find("depth") != std::string_view::npos;
}

bool is_confidence(const Topic& topic) {
  return topic.name.find("confidence") != std::string::npos;
}

/// Number of names, of folders and topics, with which both begin.
int shared_names(const std::string& a, const std::string& b) {
  const auto [end, ignored]{std::ranges::mismatch(a, b)};
  return static_cast<int>(std::count(a.begin(), end, '/'));
}

bool has_name(const std::string& topic, std::string_view name) {
  return ("/" + topic + "/").find(fmt::format("/{}", name)) != std::string::npos;
}

/// Rank of images as those of the left camera, to which stereo depth belongs: 2, 1 (another camera of the same
/// device), 0 (the right one).
int side_of(const std::string& images) {
  constexpr std::array<std::string_view, 4> left{"left", "infra1", "cam0", "ir"};
  constexpr std::array<std::string_view, 4> right{"right", "infra2", "cam1", "confidence"};
  const auto is_in = [&](std::string_view name) { return images.find(name) != std::string::npos; };
  if (std::ranges::any_of(right, is_in)) return 0;
  return std::ranges::any_of(left,
                             [&](std::string_view name) {
                               return has_name(images, name) ||
                                      images.find("_" + std::string{name}) != std::string::npos;
                             })
             ? 2
             : 1;
}

/// Rank of depth for these images; 0: it does not belong to them.
int fit_of(const Topic& images, const Topic& depth) {
  const std::string parent{parent_of(base_of(depth))};
  const std::string_view folder{last_of(parent)};
  if (folder.starts_with(aligned)) return has_name(base_of(images), folder.substr(aligned.size())) ? 3 : 0;
  const int side{side_of(base_of(images))};
  const bool is_registered{depth.name.find("registered") != std::string::npos};
  if (side == 1 && is_registered) return 3;
  return side == 0 ? 0 : side + (side == 2 ? 1 : 0);
}

using Worth = std::tuple<int, int, bool, bool, bool, bool, bool>;

/// The better one is the larger.
Worth worth_of(const Topic& images, const Topic& depth) {
  return {shared_names(base_of(images), base_of(depth)),
          fit_of(images, depth),
          is_rectified(images),
          base_of(images).find("color") == std::string::npos,
          depth.type == messages::stereo_msgs::DisparityImage::type_name,
          !is_compressed(depth),
          !is_compressed(images)};
}

struct Candidate {
  const Topic* images;
  const Topic* depth;
  SecondTopic kind;
  Worth worth;
};

std::vector<Candidate> candidates_of(const std::vector<Topic>& topics, const Encodings& encodings,
                                     const ImageTopics& asked) {
  std::vector<Candidate> all;
  for (const Topic& depth : topics) {
    const auto kind{depth_kind_of(depth, encodings)};
    if (!kind || (!asked.right.empty() && depth.name != asked.right)) continue;
    for (const Topic& images : topics) {
      const bool is_asked{images.name == asked.left};
      if (!holds_images(images) || &images == &depth || (!asked.left.empty() && !is_asked)) continue;
      if (!is_asked && (depth_kind_of(images, encodings) || is_confidence(images))) continue;
      if (is_asked || fit_of(images, depth) > 0) all.push_back({&images, &depth, *kind, worth_of(images, depth)});
    }
  }
  return all;
}

/// The folder of a device, to which both belong.
std::string device_of(const Candidate& one) {
  const std::string name{base_of(*one.images)};
  const std::string depth{base_of(*one.depth)};
  const auto [end, ignored]{std::ranges::mismatch(name, depth)};
  return parent_of(std::string{name.begin(), end});
}

}  // namespace

std::optional<SecondTopic> depth_kind_of(const Topic& topic, const Encodings& encodings) {
  if (topic.message_count == 0 || is_confidence(topic)) return std::nullopt;
  if (topic.type == messages::stereo_msgs::DisparityImage::type_name) return SecondTopic::disparity;
  if (!is_image_message(topic)) return std::nullopt;
  if (is_depth_name(topic)) return SecondTopic::depth;
  const auto found{encodings.find(topic.name)};
  const bool is_depth{found != encodings.end() && (found->second == "16UC1" || found->second == "32FC1")};
  return is_depth ? std::optional{SecondTopic::depth} : std::nullopt;
}

std::optional<ImageTopics> find_depth(const std::string& bag, const std::vector<Topic>& topics,
                                      const Encodings& encodings, const ImageTopics& asked) {
  const std::vector<Candidate> all{candidates_of(topics, encodings, asked)};
  if (all.empty()) return std::nullopt;
  const Candidate& best{*std::ranges::max_element(all, {}, &Candidate::worth)};
  std::set<std::string> devices;
  for (const Candidate& one : all) {
    if (std::get<0>(one.worth) == std::get<0>(best.worth)) devices.insert(device_of(one));
  }
  if (devices.size() > 1 && asked.left.empty() && asked.right.empty()) {
    std::string list;
    for (const std::string& device : devices) list += (list.empty() ? "" : ", ") + io::printable(device);
    throw InputError{bag, fmt::format("holds images with depth of more than one camera: {}.", list), say_which};
  }
  return ImageTopics{best.images->name, best.depth->name, best.kind};
}

std::string list_of_videos(const std::vector<Topic>& topics) {
  constexpr std::array<std::string_view, 4> types{"foxglove_msgs/msg/CompressedVideo",
                                                  "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
                                                  "foxglove.CompressedVideo", "theora_image_transport/msg/Packet"};
  std::string list;
  for (const Topic& topic : topics) {
    if (std::ranges::find(types, topic.type) == types.end()) continue;
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", io::printable(topic.name), last_of(topic.type));
  }
  return list;
}

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
  found.right = right_name_of(found.images, there);
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
