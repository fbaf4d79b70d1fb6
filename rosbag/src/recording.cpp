// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/rosbag.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "images.hpp"
#include "search.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"

namespace stereogrid::rosbag {
namespace {

namespace fs = std::filesystem;

bool is_bag_file(const fs::path& path) {
  const bool is_packed{path.extension() == ".zst" || path.extension() == ".zstd"};
  const fs::path extension{is_packed ? path.stem().extension() : path.extension()};
  if (extension == ".svo" || extension == ".svo2") return false;  // begins as MCAP; refused with what to do
  if (extension == ".mcap" || extension == ".db3" || extension == ".bag") return true;  // .bag: refused with what to do
  constexpr std::size_t longest_beginning{8};
  const std::string start{io::first_bytes(path, longest_beginning)};
  return start.starts_with("\x89MCAP0") || start == "SQLite f" || start.starts_with("#ROS");
}

/// Warns of unused images, with the reasons.
void warn_of_rest(io::ForeignRecording& found, const ImageTopics& topics, const Shots& left, const Shots& right,
                  double tolerance_ms) {
  const auto warn = [&](const std::string& topic, const Shots& shots) {
    if (shots.damaged > 0) {
      found.warnings.push_back(
          fmt::format("{}: {} messages are damaged and left out", io::printable(topic), shots.damaged));
    }
    const std::size_t alone{shots.shots.size() - found.stamps_ns.size()};
    if (alone > 0) {
      found.warnings.push_back(fmt::format("{}: {} of {} images have no partner within {:g} ms and are left out",
                                           io::printable(topic), alone, shots.shots.size(), tolerance_ms));
    }
  };
  warn(topics.left, left);
  warn(topics.right, right);
  if (!left.are_stamped || !right.are_stamped) {
    found.warnings.emplace_back("the images have no stamps: those of their recording are taken");
  }
}

std::vector<ShotPair> pairs_of(const std::string& name, const ImageTopics& topics, const Shots& left,
                               const Shots& right, double tolerance_ms) {
  std::vector<ShotPair> pairs{pair_up(left.shots, right.shots, std::llround(tolerance_ms * 1e6))};
  if (!pairs.empty()) return pairs;
  for (const auto& [topic, shots] : {std::pair{&topics.left, &left}, {&topics.right, &right}}) {
    if (!shots->shots.empty()) continue;
    throw InputError{name, fmt::format("all {} messages on {} are damaged.", shots->damaged, *topic),
                     "Record them again."};
  }
  throw InputError{name,
                   fmt::format("none of the {} images on {} and {} on {} are of the same instant, to {:g} ms.",
                               left.shots.size(), topics.left, right.shots.size(), topics.right, tolerance_ms),
                   "Trigger the cameras together, or set --pair-tolerance-ms higher."};
}

/// frame_id of the first message that can be decoded; "": none.
std::string frame_of_first(const mcap::Bag& bag, const std::string& topic) {
  const auto cursor{bag.messages({.topics = {topic}})};
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      return frame_id_of(message->data);
    } catch (const InputError&) {
      continue;
    }
  }
  return {};
}

/// Moves poses from their frame to the left camera, by /tf_static.
void move_to_camera(io::ForeignRecording& found, BagPoses& poses, const mcap::Bag& bag,
                    const std::string& camera_frame) {
  TransformBuffer transforms;
  add_static_transforms(transforms, bag);
  const auto camera{camera_in_vehicle(transforms, poses.frame, camera_frame)};
  if (!camera) {
    found.notes.push_back(
        fmt::format("poses: {} is taken as the point below the left camera; /tf_static does not connect "
                    "it with the images' frame '{}'",
                    io::printable(poses.frame, 60), io::printable(camera_frame, 60)));
    return;
  }
  for (io::StampedPose& pose : poses.poses) pose.world_from_vehicle = pose.world_from_vehicle * *camera;
  found.poses_source +=
      fmt::format(", moved from {} to the left camera by /tf_static ({:.2f} m ahead, {:.2f} m to the left)",
                  io::printable(poses.frame, 60), camera->x_m, camera->y_m);
}

/// Grids of another program, and where they lie: by /tf_static, or in the frame of the poses.
void find_grids(io::ForeignRecording& found, BagImages& images, const mcap::Bag& bag, const std::string& asked,
                const std::string& camera_frame, const std::string& world_frame) {
  BagGrids grids{choose_grid_topics(bag.topics(), asked), {}};
  found.why_no_grids = grids.topics.reason;
  if (grids.topics.cells.empty()) return;
  grids.cells = find_shots(bag, grids.topics.cells).shots;
  if (!grids.topics.certainty.empty()) grids.certainty = find_shots(bag, grids.topics.certainty).shots;
  found.grids_source = io::printable(grids.topics.cells);
  if (!grids.certainty.empty()) found.grids_source += " with " + io::printable(grids.topics.certainty);
  const std::string frame{frame_of_first(bag, grids.topics.cells)};
  TransformBuffer transforms;
  add_static_transforms(transforms, bag);
  const bool is_of_image{frame == camera_frame};  // the axes are a body's all the same
  const auto camera{is_of_image ? std::nullopt : camera_in_vehicle(transforms, frame, camera_frame)};
  grids.is_in_world = !camera && !frame.empty() && frame == world_frame && found.poses.size() > 1;
  if (camera) grids.base_from_grid = inverse(*camera);
  if (const bool is_fixed{frame == "map" || frame == "odom" || frame == world_frame};
      is_fixed && !camera && !grids.is_in_world) {
    found.grids_source.clear();
    found.why_no_grids = fmt::format("has grids in '{}' on {}, but no poses in that frame", io::printable(frame, 60),
                                     io::printable(grids.topics.cells));
    return;
  }
  found.grids_source += fmt::format(" in '{}'", io::printable(frame, 60));
  if (!camera && !grids.is_in_world) {
    found.grids_source += ", taken as that of the point below the left camera, x ahead";
    if (!is_of_image)
      found.grids_source += fmt::format("; /tf_static does not connect it with '{}'", io::printable(camera_frame, 60));
  }
  images.set_grids(std::move(grids));
}

/// Poses of the bag, unless most of them were dropped: the rest of such a topic has gaps.
/// Returns the frame that they are in.
std::string take_poses(io::ForeignRecording& found, const mcap::Bag& bag, const std::string& wanted,
                       const std::string& left_topic) {
  if (!wanted.empty() && wanted != "file") return {};
  BagPoses poses{poses_of(bag)};
  if (poses.source.empty()) return {};
  const PoseTally& tally{poses.tally};
  const std::string dropped{tally.text()};
  found.poses_source = poses.source + (dropped.empty() ? "" : ", " + dropped);
  const bool are_used{poses.poses.size() >= 2 && tally.dropped() <= tally.poses / 2};
  if (!dropped.empty()) {
    found.warnings.push_back(fmt::format(
        "{}: {}. {} Correct what publishes them, or give --poses odometry.", poses.source, dropped,
        are_used ? "The others are used, interpolated over short gaps." : "No pose of this topic is used."));
  }
  if (are_used) {
    move_to_camera(found, poses, bag, frame_of_first(bag, left_topic));
    found.poses = std::move(poses.poses);
    if (!poses.others.empty()) found.notes.push_back(fmt::format("poses: not taken:{}", poses.others));
  } else if (tally.poses == 0) {
    found.poses_source +=
        fmt::format(" is not there{}{}", tally.transforms.empty() ? "" : ", only ", fmt::join(tally.transforms, ", "));
  } else if (dropped.empty()) {
    found.poses_source += ": too few poses, two stamps are needed";
  }
  return poses.world_frame;
}

/// Throws InputError. Topics are compared in pairs: O(n²).
void check_number_of_topics(const std::string& name, const std::vector<mcap::Topic>& topics) {
  constexpr std::ptrdiff_t most_topics{1000};
  const auto of_cameras{std::ranges::count_if(topics, [](const mcap::Topic& topic) {
    return topic.message_count > 0 && topic.type.starts_with("sensor_msgs/msg/") &&
           (topic.type.ends_with("Image") || topic.type.ends_with("CameraInfo"));
  })};
  if (of_cameras <= most_topics) return;
  throw InputError{name,
                   fmt::format("has images and CameraInfo on {} topics (allowed up to {}).", of_cameras, most_topics),
                   "Record the topics of the cameras that are used."};
}

/// Encodings of the first messages, which distinguish depth from images if names do not.
Encodings encodings_of(const mcap::Bag& bag) {
  Encodings encodings;
  for (const mcap::Topic& topic : bag.topics()) {
    if (topic.type != messages::sensor_msgs::Image::type_name || topic.message_count == 0) continue;
    const auto cursor{bag.messages({.topics = {topic.name}})};
    const mcap::Message* const message{cursor->next()};
    if (message == nullptr) continue;
    try {
      messages::sensor_msgs::Image image;
      messages::decode(message->data, image);
      encodings[topic.name] = image.encoding;
    } catch (const InputError&) {  // counted where the images are listed
    }
  }
  return encodings;
}

/// Value in the first image that can be decoded; 0: none.
std::pair<int, int> image_size_of(const mcap::Bag& bag, const std::string& topic) {
  const auto cursor{bag.messages({.topics = {topic}})};
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      const auto image{decode_image(message->data, is_compressed(*find_topic(bag.topics(), topic)), topic).grey};
      return {image.width(), image.height()};
    } catch (const InputError&) {
      continue;
    }
  }
  return {0, 0};
}

/// Value in the first CameraInfo; 0: none.
std::pair<std::uint32_t, std::uint32_t> info_size_of(const mcap::Bag& bag) {
  const auto is_info = [](const mcap::Topic& topic) {
    return topic.type == messages::sensor_msgs::CameraInfo::type_name && topic.message_count > 0;
  };
  const auto topic{std::ranges::find_if(bag.topics(), is_info)};
  if (topic == bag.topics().end()) return {0, 0};
  const auto cursor{bag.messages({.topics = {topic->name}})};
  messages::sensor_msgs::CameraInfo info;
  try {
    if (const mcap::Message* const message{cursor->next()}) messages::decode(message->data, info);
  } catch (const InputError&) {
    return {0, 0};
  }
  return {info.width, info.height};
}

/// Halves of the images of one topic, by the size in CameraInfo, else by their shape. Throws InputError: images of one
/// camera.
SecondTopic layout_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics) {
  const auto [width_px, height_px]{image_size_of(bag, topics.left)};
  const auto [info_width, info_height]{info_size_of(bag)};
  const double aspect{static_cast<double>(width_px) / std::max(1, height_px)};
  const double of_one{info_height > 0 ? static_cast<double>(info_width) / info_height : 0};
  const auto is_near = [&](double wanted) { return of_one > 0 && std::abs(aspect / wanted - 1) < 0.01; };
  constexpr double wide{2.2};
  if (is_near(2 * of_one) || (of_one == 0 && aspect >= wide)) return SecondTopic::beside;
  if (is_near(of_one / 2) || (of_one == 0 && aspect > 0 && aspect <= 1)) return SecondTopic::below;
  const std::string videos{list_of_videos(bag.topics())};
  throw InputError{
      name,
      fmt::format("has the images of one camera alone: {}, {}×{} px. Missing are right images, depth, or a "
                  "right half.{}",
                  topics.left, width_px, height_px,
                  videos.empty() ? "" : fmt::format(" Video is not read: {}.", videos)),
      "Record the right camera's images or depth, too; say which with --left-topic TOPIC --right-topic "
      "TOPIC."};
}

}  // namespace

bool is_bag(const fs::path& path) {
  if (!io::is_folder(path)) return is_bag_file(path);
  constexpr std::array<const char*, 10> of_others{"left",    "right",    "image_0",  "image_1",  "image_2",
                                                  "image_3", "image_00", "image_01", "image_02", "image_03"};
  if (std::ranges::any_of(of_others, [&](const char* name) { return io::is_folder(path / name); })) {
    return false;
  }
  return io::is_there(path / "metadata.yaml") || std::ranges::any_of(io::entries_of(path), is_bag_file);
}

std::unique_ptr<io::Recording> bag_recording(std::unique_ptr<mcap::Bag> bag, const io::InputArguments& arguments,
                                             const BagOptions& options) {
  const fs::path& path{arguments.paths.front()};
  const std::string name{io::printable_path(path)};
  const mcap::Bag& opened{*bag};
  check_number_of_topics(name, bag->topics());
  ImageTopics topics{choose_image_topics(name, bag->topics(), options.topics, encodings_of(*bag))};
  if (topics.is_one_topic()) topics.second = layout_of(*bag, name, topics);
  const Shots left{find_shots(*bag, topics.left)};
  const Shots right{topics.is_one_topic() ? left : find_shots(*bag, topics.right)};
  std::vector<ShotPair> pairs{pairs_of(name, topics, left, right, options.pair_tolerance_ms)};
  io::ForeignRecording found;
  found.kind = fmt::format("ROS 2 bag, {} and {}", io::printable(topics.left), io::printable(topics.right));
  if (topics.is_one_topic()) found.kind = fmt::format("ROS 2 bag, both images of {}", io::printable(topics.left));
  found.root = path;
  if (topics.has_depth()) found.external = second_of(topics);
  for (const ShotPair& pair : pairs) found.stamps_ns.push_back(pair.first.stamp_ns);
  warn_of_rest(found, topics, left, right, options.pair_tolerance_ms);
  auto images{std::make_unique<BagImages>(std::move(bag), name, topics, std::move(pairs))};
  const io::ImagePair first{images->begin()};
  found.width_px = first.left.width();
  found.height_px = first.left.height();
  found.sample_bits = images->sample_bits();
  if (first.has_other_byte_order) {
    found.warnings.emplace_back(
        "is_bigendian of the images is wrong: in the other byte order they are much smoother, and it is taken. Correct "
        "the driver.");
  }
  if (!arguments.calibration) {
    found.calibration = calibration_of(opened, name, topics, found.width_px, found.height_px);
  }
  const std::string world_frame{take_poses(found, opened, arguments.poses, topics.left)};
  find_grids(found, *images, opened, options.grid_topic, frame_of_first(opened, topics.left), world_frame);
  for (std::string& sentence : opened.damage()) found.warnings.push_back(std::move(sentence));
  found.images = std::move(images);
  return io::open_recording(arguments, std::move(found));
}

std::unique_ptr<io::Recording> open_recording(const io::InputArguments& arguments, const BagOptions& options) {
  return bag_recording(mcap::open_bag(arguments.paths.front()), arguments, options);
}

}  // namespace stereogrid::rosbag
