// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "ros2/ros2_source.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/ros_image.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using messages::sensor_msgs::CameraInfo;

constexpr auto third_after{500ms};     // wait for a third camera on one topic
constexpr std::size_t info_depth{10};  // both cameras may share a topic

/// First CameraInfo of each camera, by topic, kept for the lifetime of the node.
struct Infos {
  std::mutex mutex;
  std::array<std::vector<CameraInfo>, 2> messages;
};

/// Both cameras' where they have come; the right one's topic may be that of the left one.
std::optional<std::array<CameraInfo, 2>> both_of(Infos& infos, bool are_on_one_topic) {
  const std::scoped_lock lock{infos.mutex};
  const auto& [first, second]{infos.messages};
  if (are_on_one_topic && first.size() == 2) return std::array{first[0], first[1]};
  if (!are_on_one_topic && !first.empty() && !second.empty()) return std::array{first[0], second[0]};
  return std::nullopt;
}

std::string missing_infos(Infos& infos, const std::array<std::string, 2>& topics) {
  const std::scoped_lock lock{infos.mutex};
  if (topics[0] == topics[1] && !infos.messages[0].empty()) {
    return fmt::format("{} has the CameraInfo of {}, but has to have that of two cameras.", io::printable(topics[0]),
                       infos.messages[0].size() == 1 ? "one camera" : "more than two cameras");
  }
  std::string missing;
  for (std::size_t i{0}; i < (topics[0] == topics[1] ? 1 : 2); ++i) {
    if (infos.messages.at(i).empty()) missing += (missing.empty() ? "" : " and on ") + io::printable(topics.at(i));
  }
  return fmt::format("there is no CameraInfo on {}.", missing);
}

std::array<CameraInfo, 2> wait_for_infos(dds::Node& node, const std::string& name,
                                         const std::array<std::string, 2>& topics) {
  const auto infos{std::make_shared<Infos>()};
  const bool are_on_one_topic{topics[0] == topics[1]};
  for (std::size_t i{0}; i < (are_on_one_topic ? 1 : 2); ++i) {
    node.subscribe(topics[i], std::string{CameraInfo::type_name}, info_depth,
                   [infos, i](std::span<const std::byte> cdr) {
                     CameraInfo info;
                     messages::decode(cdr, info);
                     const std::scoped_lock lock{infos->mutex};
                     rosbag::add_camera(infos->messages.at(i), info);
                   });
  }
  Waiting waiting;
  if (are_on_one_topic) std::this_thread::sleep_for(third_after);
  for (;;) {
    if (auto both{both_of(*infos, are_on_one_topic)}) return *std::move(both);
    waiting.print(fmt::format("{}: {} A calibration.yaml can be given instead (--calibration FILE).", name,
                              missing_infos(*infos, topics)));
  }
}

LiveCalibration stereo_calibration(dds::Node& node, const InputOptions& options, const FoundImages& found) {
  if (!options.calibration.empty()) return {io::read_calibration(options.calibration)};
  const std::array<std::string, 2> topics{rosbag::info_topic_of(found.left), rosbag::info_topic_of(found.right)};
  auto [left_info, right_info]{wait_for_infos(node, options.paths.front(), topics)};
  if (std::max(left_info.width, left_info.height) > io::largest_side_px) {
    throw InputError{topics[0], fmt::format("the CameraInfo is for {}×{} px.", left_info.width, left_info.height),
                     "Give a calibration.yaml with --calibration FILE (docs/input.md)."};
  }
  const auto width_px{static_cast<int>(left_info.width)};
  const auto height_px{static_cast<int>(left_info.height)};
  const std::string frame{left_info.header.frame_id};
  return {rosbag::calibration_of(
              {std::move(left_info), topics[0], topics[0]}, {std::move(right_info), topics[1], topics[1]},
              rosbag::is_rectified(found.left) && rosbag::is_rectified(found.right), width_px, height_px),
          frame};
}

/// Calibration messages of images with depth.
struct DepthMessages {
  Image<std::uint8_t> images;
  Image<float> depth_m;
  std::optional<rosbag::DepthInfos> infos;  ///< none: a file is given
};

rosbag::NamedInfo info_on(const NewestMessages& messages, const std::string& name, const std::string& topic) {
  const auto cdr{messages.of(topic)};
  if (!cdr) {
    throw InputError{name, fmt::format("there is no CameraInfo on {}.", topic),
                     "A calibration.yaml can be given instead (--calibration FILE)."};
  }
  rosbag::NamedInfo info{{}, name + ", " + io::printable(topic), io::printable(topic)};
  messages::decode(*cdr, info.message);
  return info;
}

rosbag::DepthInfos depth_infos(NewestMessages& messages, const std::string& name, const FoundImages& found,
                               const std::vector<mcap::Topic>& topics) {
  std::vector<std::string> there;
  for (const mcap::Topic& topic : topics) {
    if (topic.type == CameraInfo::type_name) there.push_back(topic.name);
  }
  const rosbag::DepthInfoTopics own{rosbag::depth_info_topics(found.left, found.right, there)};
  const bool is_depth{found.images.second == rosbag::SecondTopic::depth};
  for (const std::string& topic : {own.images, is_depth ? own.depth : "", is_depth ? own.right : ""}) {
    if (!topic.empty()) messages.add(*rosbag::find_topic(topics, topic));
  }
  rosbag::DepthInfos infos{info_on(messages, name, own.images.empty() ? rosbag::info_topic_of(found.left) : own.images),
                           {}};
  if (is_depth && !own.depth.empty()) infos.depth = info_on(messages, name, own.depth);
  if (is_depth && !own.right.empty()) {
    infos.baseline_m = rosbag::baseline_m_of(info_on(messages, name, own.right).message);
  }
  return infos;
}

/// Throws InputError: one has not come, or cannot be read.
DepthMessages depth_messages(NewestMessages& messages, const InputOptions& options, const FoundImages& found,
                             const std::vector<mcap::Topic>& topics) {
  const std::string& name{options.paths.front()};
  messages.add(found.left);
  messages.add(found.right);
  DepthMessages all;
  if (options.calibration.empty()) all.infos = depth_infos(messages, name, found, topics);
  const auto images{messages.of(found.left.name)};
  const auto depth{messages.of(found.right.name)};
  if (!images || !depth) {
    const std::string& silent{images ? found.right.name : found.left.name};
    throw InputError{name, fmt::format("no message has come on {}.", silent),
                     "Publish it, or say which: --left-topic TOPIC --right-topic TOPIC."};
  }
  all.images = rosbag::decode_image(*images, rosbag::is_compressed(found.left), io::printable(found.left.name)).grey;
  all.depth_m = rosbag::decode_depth(*depth, found.right, io::printable(found.right.name));
  const bool has_baseline{found.images.second == rosbag::SecondTopic::disparity};
  if (all.infos && has_baseline) all.infos->baseline_m = rosbag::disparity_baseline_m(*depth);
  return all;
}

DepthMessages wait_for_depth(dds::Node& node, const InputOptions& options, const FoundImages& found) {
  NewestMessages messages{node};
  Waiting waiting;
  for (;;) {
    try {
      return depth_messages(messages, options, found, topics_of(node, options));
    } catch (const InputError& error) {
      waiting.print(error.what());
    }
  }
}

LiveCalibration depth_calibration(dds::Node& node, const InputOptions& options, const FoundImages& found) {
  DepthMessages came{wait_for_depth(node, options, found)};
  const int width_px{came.images.width()};
  const int height_px{came.images.height()};
  static_cast<void>(
      io::fit_depth(std::move(came.depth_m), width_px, height_px, io::printable(found.right.name)));  // or throws
  if (!came.infos) return {io::read_depth_calibration(options.calibration, width_px, height_px)};
  const std::string frame{came.infos->images.message.header.frame_id};
  return {rosbag::calibration_of(*std::move(came.infos), found.left, found.images, width_px, height_px), frame};
}

}  // namespace

LiveCalibration live_calibration(dds::Node& node, const InputOptions& options, const FoundImages& found) {
  return found.images.has_depth() ? depth_calibration(node, options, found) : stereo_calibration(node, options, found);
}

}  // namespace stereogrid::app
