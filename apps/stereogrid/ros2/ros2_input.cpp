// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros2_input.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "ros2/ros2_source.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/mask.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/rosbag/calibration.hpp"
#include "stereogrid/rosbag/topics.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using messages::sensor_msgs::CameraInfo;
using Clock = std::chrono::steady_clock;

constexpr std::string_view scheme{"ros2:"};
constexpr auto look_every{50ms};
constexpr auto settled_after{500ms};  // image_raw may be found before image_rect
constexpr auto tell_after{2s};
constexpr std::size_t info_depth{10};  // of both cameras, where they share a topic

/// Tells what is waited for, where that has not changed for a while.
class Waiting {
 public:
  void tell(const std::string& sentence) {
    if (sentence != sentence_) {
      sentence_ = sentence;
      since_ = Clock::now();
    } else if (Clock::now() - since_ > tell_after && told_ != sentence) {
      spdlog::warn("waiting: {}", sentence);
      told_ = sentence;
    }
    std::this_thread::sleep_for(look_every);
  }

 private:
  std::string sentence_;
  std::string told_;
  Clock::time_point since_{Clock::now()};
};

std::vector<mcap::Topic> topics_of(const dds::Node& node) {
  std::vector<mcap::Topic> topics;
  for (const dds::PublishedTopic& topic : node.topics()) {
    mcap::Topic& one{topics.emplace_back()};
    one.name = topic.name;
    one.type = topic.type;
    one.message_count = 1;
  }
  return topics;
}

bool holds_images(const mcap::Topic& topic) {
  return topic.type == messages::sensor_msgs::Image::type_name || rosbag::is_compressed(topic);
}

/// Those below the folder; why there is no pair of them, as an exception.
rosbag::ImageTopics choose(const std::string& name, const std::string& folder, std::vector<mcap::Topic> topics,
                           const rosbag::ImageTopics& asked) {
  std::string elsewhere;
  const auto is_out = [&](const mcap::Topic& topic) {
    const bool is_below{topic.name.starts_with(folder + "/")};
    if (!is_below && holds_images(topic)) elsewhere += (elsewhere.empty() ? "" : ", ") + io::printable(topic.name);
    return !is_below;
  };
  if (asked.left.empty() && asked.right.empty()) std::erase_if(topics, is_out);
  if (std::ranges::any_of(topics, holds_images)) {
    rosbag::ImageTopics chosen{rosbag::choose_image_topics(name, topics, asked)};
    if (chosen.second == rosbag::SecondTopic::right) return chosen;
    throw InputError{
        name,
        fmt::format("the only images are {} and {}; depth, disparities and images in one are not read live.",
                    io::printable(chosen.left), io::printable(chosen.right)),
        "Publish the right camera's images, or record a bag."};
  }
  throw InputError{
      name, "nobody publishes images there.",
      elsewhere.empty() ? "Do ROS_DOMAIN_ID and the network fit?" : "Elsewhere there are: " + elsewhere + "."};
}

struct Found {
  rosbag::ImageTopics images;
  std::vector<mcap::Topic> topics;
};

Found wait_for_images(const dds::Node& node, const InputOptions& options) {
  const std::string& name{options.paths.front()};
  std::string folder{name.substr(scheme.size())};
  while (folder.ends_with('/')) folder.pop_back();
  Waiting waiting;
  std::string chosen;
  Clock::time_point since{Clock::now()};
  for (;;) {
    std::string missing{"for all topics to be found."};
    try {
      std::vector<mcap::Topic> topics{topics_of(node)};
      const rosbag::ImageTopics images{
          choose(name, folder, topics, {options.left_topic, options.right_topic, rosbag::SecondTopic::right})};
      if (chosen != images.left + " " + images.right) since = Clock::now();
      chosen = images.left + " " + images.right;
      if (Clock::now() - since >= settled_after) return {images, std::move(topics)};
    } catch (const InputError& error) {
      missing = error.what();
    }
    waiting.tell(missing);
  }
}

/// The first CameraInfo of each camera, by topic; the node keeps it as long as itself.
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
  if (are_on_one_topic) std::this_thread::sleep_for(settled_after);  // a third camera may be there
  for (;;) {
    if (auto both{both_of(*infos, are_on_one_topic)}) return *std::move(both);
    waiting.tell(fmt::format("{}: {} A calibration.yaml can be given instead (--calibration FILE).", name,
                             missing_infos(*infos, topics)));
  }
}

io::Calibration calibration_from(dds::Node& node, const InputOptions& options, const Found& found) {
  if (!options.calibration.empty()) return io::read_calibration(options.calibration);
  const mcap::Topic& left{*rosbag::find_topic(found.topics, found.images.left)};
  const mcap::Topic& right{*rosbag::find_topic(found.topics, found.images.right)};
  const std::array<std::string, 2> topics{rosbag::info_topic_of(left), rosbag::info_topic_of(right)};
  auto [left_info, right_info]{wait_for_infos(node, options.paths.front(), topics)};
  constexpr std::uint32_t largest_side_px{32768};
  if (left_info.width > largest_side_px || left_info.height > largest_side_px) {
    throw InputError{topics[0], fmt::format("the CameraInfo is for {}×{} px.", left_info.width, left_info.height),
                     "Give a calibration.yaml with --calibration FILE (docs/input.md)."};
  }
  const auto width_px{static_cast<int>(left_info.width)};
  const auto height_px{static_cast<int>(left_info.height)};
  return rosbag::calibration_of({std::move(left_info), topics[0], topics[0]},
                                {std::move(right_info), topics[1], topics[1]},
                                rosbag::is_rectified(left) && rosbag::is_rectified(right), width_px, height_px);
}

void check_options(const InputOptions& options) {
  if (!options.disparities.empty() || !options.depth.empty()) {
    throw ConfigError{"--disparities and --depth are of recordings, but SOURCE is ROS 2."};
  }
  const std::string& poses{options.poses};
  if (poses.empty() || poses == "odometry" || poses == "none" || poses == "tf" || poses.starts_with('/')) return;
  throw ConfigError{
      "--poses with ROS 2 are 'odometry' (found from the images), 'none', 'tf' (odom → base_link on /tf), or a topic "
      "of "
      "nav_msgs/Odometry, such as /odom."};
}

// Where it is not at the origin of the frame whose poses come, the vehicle's frame is another one.
Pose2 camera_in(Ros2Options& ros2, bool has_poses) {
  if (ros2.camera_at.empty()) return {};
  if (!has_poses) {
    throw ConfigError{
        "--ros2-camera-at says where the camera is in the frame of poses, but there are none: give --poses, too."};
  }
  constexpr double farthest_m{1000};
  for (const double value : ros2.camera_at) {
    if (!(std::abs(value) <= farthest_m)) throw ConfigError{"--ros2-camera-at: metres and degrees, up to 1000."};
  }
  if (ros2.frames.empty()) ros2.frames = {"odom", "stereo_grid"};
  constexpr double degree{3.14159265358979323846 / 180};
  return {ros2.camera_at[0], ros2.camera_at[1], ros2.camera_at[2] * degree};
}

}  // namespace

bool is_ros2(const std::string& source) {
  return source.starts_with(scheme);
}

LiveInput open_ros2_input(const InputOptions& options, Ros2Options& ros2) {
  check_options(options);
  const bool has_poses{options.poses == "tf" || options.poses.starts_with('/')};
  const Pose2 camera{camera_in(ros2, has_poses)};
  // of the robot's own frame its odometry tells
  if (has_poses && (ros2.frames.empty() || ros2.frames[1] == "base_link")) ros2.leaves_tf = true;
  std::shared_ptr<dds::Node> node{open_ros2_node(ros2)};
  const Found found{wait_for_images(*node, options)};
  const std::chrono::duration<double, std::milli> tolerance{options.pair_tolerance_ms};
  const Ros2Setup setup{
      .images = found.images,
      .is_left_compressed = rosbag::is_compressed(*rosbag::find_topic(found.topics, found.images.left)),
      .is_right_compressed = rosbag::is_compressed(*rosbag::find_topic(found.topics, found.images.right)),
      .calibration = calibration_from(*node, options, found),
      .pairing = {.tolerance = std::chrono::duration_cast<std::chrono::nanoseconds>(tolerance)},
      .poses = has_poses ? options.poses : "",
      .posed_from_camera = camera,
      .uses_sim_time = ros2.uses_sim_time};
  spdlog::info("{} and {}, {}", io::printable(setup.images.left), io::printable(setup.images.right),
               setup.calibration.kind);
  log_calibration(setup.calibration);
  LiveInput live;
  live.kind = options.paths.front();
  live.in_world_of_poses = has_poses;
  live.recording.extrinsics_given = setup.calibration.has_mounting;
  live.poses = has_poses ? PoseSource::input : options.poses == "none" ? PoseSource::none : PoseSource::odometry;
  const std::filesystem::path mask{options.mask.empty() ? setup.calibration.mask : std::filesystem::path{options.mask}};
  if (!mask.empty()) live.mask = io::read_mask(mask, setup.calibration);
  live.source = std::make_unique<Ros2Source>(std::move(node), setup);
  return live;
}

}  // namespace stereogrid::app
