// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/rosbag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <tuple>
#include <utility>

#include "search.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::rosbag {
namespace {

using mcap::Topic;

/// Names of cameras. The first that fits counts: cam1 is the right camera beside cam0, and the left one beside cam2.
constexpr auto names_of_sides{std::to_array<std::pair<std::string_view, std::string_view>>({{"left", "right"},
                                                                                            {"Left", "Right"},
                                                                                            {"LEFT", "RIGHT"},
                                                                                            {"infra1", "infra2"},
                                                                                            {"cam0", "cam1"},
                                                                                            {"cam_0", "cam_1"},
                                                                                            {"camera0", "camera1"},
                                                                                            {"camera_0", "camera_1"},
                                                                                            {"image0", "image1"},
                                                                                            {"cam1", "cam2"},
                                                                                            {"cam_1", "cam_2"},
                                                                                            {"camera1", "camera2"},
                                                                                            {"camera_1", "camera_2"},
                                                                                            {"/l/", "/r/"},
                                                                                            {"/L/", "/R/"},
                                                                                            {"_l/", "_r/"},
                                                                                            {"_L/", "_R/"},
                                                                                            {"/0/", "/1/"},
                                                                                            {"_0/", "_1/"}})};

/// The name with the last word replaced, with the last two, and so on: /left/left/image has /left/right/image beside
/// it, left/image_left has right/image_right. A word that ends with a slash may be the last of a name.
std::vector<std::string> replacements(std::string name, std::string_view word, std::string_view by) {
  name += '/';
  std::vector<std::string> all;
  for (std::size_t at{name.rfind(word)}; at != std::string::npos; at = at == 0 ? at - 1 : name.rfind(word, at - 1)) {
    name.replace(at, word.size(), by);
    all.push_back(name.substr(0, name.size() - 1));
  }
  return all;
}

/// Place of the last such word; -1: none.
std::ptrdiff_t last_of(const std::string& name, std::string_view word) {
  return static_cast<std::ptrdiff_t>((name + '/').rfind(word));
}

/// The right camera's topic of the same kind; nullptr: there is none, or this is one.
const Topic* right_of(const Topic& left, const std::vector<Topic>& topics) {
  const auto other_of = [&](std::string_view own, std::string_view other) -> const Topic* {
    for (const std::string& name : replacements(left.name, own, other)) {
      const Topic* const found{find_topic(topics, name)};
      if (found != nullptr && found->type == left.type) return found;
    }
    return nullptr;
  };
  for (const auto& [left_name, right_name] : names_of_sides) {
    const bool is_right{last_of(left.name, right_name) > last_of(left.name, left_name)};
    const Topic* const other{is_right ? other_of(right_name, left_name) : other_of(left_name, right_name)};
    if (other != nullptr) return is_right ? nullptr : other;
  }
  return nullptr;
}

std::string list_of(const std::vector<Topic>& topics) {
  std::string list;
  for (const Topic& topic : topics) {
    if (holds_images(topic)) list += (list.empty() ? "" : ", ") + io::printable(topic.name);
  }
  return list;
}

/// The better one is the larger: rectified, grey, as the camera has given it.
std::tuple<bool, bool, bool> worth(const Topic* images) {
  return {is_rectified(*images), base_of(*images).find("color") == std::string::npos, !is_compressed(*images)};
}

/// Folder of the camera, without names of kinds of its images: left/color/rect and left_raw_gray are left.
std::string camera_of(const Topic& images) {
  constexpr std::array<std::string_view, 4> kinds{"color", "gray", "rect", "raw"};
  std::string camera;
  std::istringstream folders{parent_of(base_of(images))};
  for (std::string folder; std::getline(folders, folder, '/');) {
    for (const std::string_view suffix : {"_gray", "_raw"}) {
      if (folder.ends_with(suffix)) folder.resize(folder.size() - suffix.size());
    }
    if (std::ranges::find(kinds, folder) == kinds.end()) camera.append("/").append(folder);
  }
  return camera;
}

/// The one topic of images that are no depth; nullptr: there are several.
const Topic* single_topic(const std::vector<Topic>& topics, const Encodings& encodings) {
  const Topic* single{nullptr};
  for (const Topic& topic : topics) {
    if (!holds_images(topic) || depth_kind_of(topic, encodings)) continue;
    if (single != nullptr && base_of(*single) != base_of(topic)) return nullptr;
    if (single == nullptr || is_compressed(*single)) single = &topic;
  }
  return single;
}

ImageTopics found(const std::string& bag, const std::vector<Topic>& topics, const Encodings& encodings) {
  std::vector<const Topic*> candidates;
  std::set<std::string> cameras;
  for (const Topic& topic : topics) {
    if (!holds_images(topic) || depth_kind_of(topic, {}) || right_of(topic, topics) == nullptr) continue;
    candidates.push_back(&topic);
    cameras.insert(camera_of(topic));
  }
  const std::string list{list_of(topics)};
  if (candidates.empty()) {
    if (const auto depth{find_depth(bag, topics, encodings, {})}) return *depth;
    if (const Topic* const one{single_topic(topics, encodings)}) return {one->name, one->name, SecondTopic::beside};
    throw InputError{bag,
                     fmt::format("no two topics of images are called left and right, and none is depth beside images. "
                                 "There are: {}.",
                                 list),
                     say_which};
  }
  if (cameras.size() > 1) {
    throw InputError{bag, fmt::format("holds images of more than one pair of cameras: {}.", list),
                     std::string{say_which} + " Or make one grid of all: --cameras /front,/rear (their namespaces)."};
  }
  const Topic* const best{*std::ranges::max_element(candidates, {}, worth)};
  return {best->name, right_of(*best, topics)->name};
}

void need_images(const std::string& bag, const std::vector<Topic>& topics, const std::string& name) {
  const Topic* const topic{find_topic(topics, name)};
  if (topic != nullptr && (holds_images(*topic) || depth_kind_of(*topic, {}))) return;
  throw InputError{bag, fmt::format("has no images on {}. There are: {}.", name, list_of(topics)), say_which};
}

struct Reason {
  std::string what;
  const char* mend;
};

/// Content of a recording without ROS 2's images.
Reason reason_without_images(const std::vector<Topic>& topics) {
  const auto first_with = [&](auto&& is_it) -> const Topic* {
    const auto found{std::ranges::find_if(topics, is_it)};
    return found == topics.end() ? nullptr : &*found;
  };
  const auto is_of_ros1 = [](const Topic& t) { return t.message_encoding == "ros1" || t.schema_encoding == "ros1msg"; };
  if (const std::string videos{list_of_videos(topics)}; !videos.empty()) {
    return {fmt::format("holds video (H.264 or the like) on {}, which is not read (allowed: sensor_msgs/Image and "
                        "CompressedImage).",
                        videos),
            "Turn it into images: play the bag (ros2 bag play), decode each topic (ros2 run image_transport "
            "republish ffmpeg raw), and record the output (ros2 bag record)."};
  }
  if (first_with(is_of_ros1) != nullptr) {
    return {"holds messages of ROS 1 in an MCAP file, which are not read (allowed: those of ROS 2).",
            "Convert the original bag: pip install rosbags, then rosbags-convert --src FILE.bag --dst FOLDER."};
  }
  if (first_with([](const Topic& t) { return t.name.find("/stereo_grid/") == 0 || t.name == "/stereo_grid"; }) !=
      nullptr) {
    return {"holds results of stereogrid (--mcap), and no images.",
            "Show them with 'stereogrid view'; name the recording "
            "of the cameras as INPUT."};
  }
  const auto is_foreign = [](const Topic& t) {
    return t.type.find("Image") != std::string::npos && t.message_encoding != "cdr";
  };
  if (const Topic* const topic{first_with(is_foreign)}) {
    return {fmt::format("has images as {} messages of {}, which are not read (allowed: sensor_msgs/Image and "
                        "CompressedImage of ROS 2).",
                        io::printable(topic->message_encoding, 40), io::printable(topic->type, 60)),
            "Write the images as PNG or JPEG into left/ and right/ (Foxglove's Python package mcap reads them)."};
  }
  return {"holds no images (sensor_msgs/Image or CompressedImage).", "Record those of both cameras."};
}

[[noreturn]] void fail_without_images(const std::string& bag, const std::vector<Topic>& topics) {
  const Reason reason{reason_without_images(topics)};
  throw InputError{bag, reason.what, reason.mend};
}

/// `asked.left` is there, `asked.right` may be.
ImageTopics completed(const std::string& bag, const std::vector<Topic>& topics, const ImageTopics& asked,
                      const Encodings& encodings) {
  need_images(bag, topics, asked.left);
  ImageTopics chosen{asked.left, asked.right};
  const Topic& left{*find_topic(topics, asked.left)};
  if (chosen.right.empty()) {
    if (const Topic* const right{right_of(left, topics)}) return {asked.left, right->name};
    if (const auto depth{find_depth(bag, topics, encodings, asked)}) return *depth;
    throw InputError{
        bag, fmt::format("no topic of the right camera is called like {}. There are: {}.", asked.left, list_of(topics)),
        say_which};
  }
  need_images(bag, topics, chosen.right);
  const Topic& second{*find_topic(topics, chosen.right)};
  const auto encoding = [&](const Topic& topic) {
    const auto known{encodings.find(topic.name)};
    return known == encodings.end() ? std::string{} : known->second;
  };
  const auto kind{depth_kind_of(second, encodings)};
  if (kind && encoding(left) != encoding(second)) chosen.second = *kind;
  if (kind && !encodings.contains(second.name)) chosen.second = *kind;
  if (chosen.left == chosen.right) throw InputError{bag, "left and right are the same topic.", say_which};
  return chosen;
}

}  // namespace

ImageTopics choose_image_topics(const std::string& bag, const std::vector<Topic>& topics, const ImageTopics& asked,
                                const Encodings& encodings) {
  if (std::ranges::none_of(topics, holds_images)) fail_without_images(bag, topics);
  if (asked.left.empty() && asked.right.empty()) return found(bag, topics, encodings);
  if (!asked.left.empty()) return completed(bag, topics, asked, encodings);
  if (const auto depth{find_depth(bag, topics, encodings, asked)}) return *depth;
  throw InputError{bag, "the right camera's topic alone was given.", say_which};
}

std::string second_of(const ImageTopics& topics) {
  const char* const kind{topics.second == SecondTopic::depth       ? "depth of "
                         : topics.second == SecondTopic::disparity ? "disparities of "
                                                                   : ""};
  return kind + io::printable(topics.right);
}

bool holds_images(const Topic& topic) {
  const bool is_plain{topic.type == messages::sensor_msgs::Image::type_name};
  return topic.message_count > 0 && (is_plain || is_compressed(topic)) && !topic.name.ends_with("/compressedDepth");
}

std::string parent_of(const std::string& name) {
  const std::size_t slash{name.rfind('/')};
  return slash == std::string::npos ? std::string{} : name.substr(0, slash);
}

std::string base_of(const Topic& images) {
  return is_compressed(images) ? parent_of(images.name) : images.name;
}

std::string right_name_of(const std::string& left, const std::vector<std::string>& there) {
  for (const auto& [left_name, right_name] : names_of_sides) {
    for (const std::string& name : replacements(left, left_name, right_name)) {
      if (std::ranges::find(there, name) != there.end()) return name;
    }
  }
  return {};
}

const Topic* find_topic(const std::vector<Topic>& topics, const std::string& name) {
  const auto found{
      std::ranges::find_if(topics, [&](const Topic& topic) { return topic.name == name && topic.message_count > 0; })};
  return found == topics.end() ? nullptr : &*found;
}

std::string info_topic_of(const Topic& images) {
  return parent_of(base_of(images)) + "/camera_info";
}

std::string info_topic_of(const Topic& images, const std::vector<std::string>& there) {
  const std::string base{base_of(images)};
  const std::string last{base.substr(base.rfind('/') + 1)};
  const std::size_t word{last.find("image")};
  std::vector<std::string> names{base + "/camera_info", base + "_camera_info", base + "_info"};
  if (word != std::string::npos) {
    names.push_back(parent_of(base) + '/' + last.substr(0, word) + "camera_info" + last.substr(word + 5));
  }
  const auto is_there = [&](const std::string& name) { return std::ranges::find(there, name) != there.end(); };
  const auto found{std::ranges::find_if(names, is_there)};
  return found == names.end() ? info_topic_of(images) : *found;
}

bool is_rectified(const Topic& images) {
  const std::string base{base_of(images)};
  return base.find("rect", base.rfind('/') + 1) != std::string::npos || parent_of(base).ends_with("/rect");
}

bool is_compressed(const Topic& images) {
  return images.type == messages::sensor_msgs::CompressedImage::type_name;
}

}  // namespace stereogrid::rosbag
