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

/// Names of frames of TF.
struct BagFrames {
  std::string camera;
  std::string vehicle{"base_link"};  ///< or the one that the poses are of
  std::string world;                 ///< frame of the poses; "": none
};

/// Sets poses of the bag, unless most of them were dropped: the rest of such a topic has gaps. `is_placed`: the
/// camera has its place in the vehicle; else the poses are moved to it.
void take_poses(io::ForeignRecording& found, const mcap::Bag& bag, const std::string& wanted, bool is_placed,
                BagFrames& frames) {
  if (!wanted.empty() && wanted != "file") return;
  BagPoses poses{poses_of(bag)};
  if (poses.source.empty()) return;
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
    if (!is_placed) move_to_camera(found, poses, bag, frames.camera);
    frames.vehicle = poses.frame;
    found.poses = std::move(poses.poses);
    if (!poses.others.empty()) found.notes.push_back(fmt::format("poses: not taken:{}", poses.others));
  } else if (tally.poses == 0) {
    found.poses_source +=
        fmt::format(" is not there{}{}", tally.transforms.empty() ? "" : ", only ", fmt::join(tally.transforms, ", "));
  } else if (dropped.empty()) {
    found.poses_source += ": too few poses, two stamps are needed";
  }
  frames.world = poses.world_frame;
}

bool is_of_camera(const mcap::Topic& topic) {
  return topic.type.starts_with("sensor_msgs/msg/") &&
         (topic.type.ends_with("Image") || topic.type.ends_with("CameraInfo"));
}

/// A bag with the images and CameraInfo of one namespace alone.
class OneCamera final : public mcap::Bag {
 public:
  OneCamera(std::unique_ptr<mcap::Bag> bag, const std::string& name_space) : bag_{std::move(bag)} {
    std::ranges::copy_if(bag_->topics(), std::back_inserter(topics_), [&](const mcap::Topic& topic) {
      const bool is_seen{is_of_camera(topic) || depth_kind_of(topic, {})};
      return !is_seen || topic.name.starts_with(name_space + "/");
    });
  }

  [[nodiscard]] const std::vector<mcap::Topic>& topics() const override { return topics_; }
  [[nodiscard]] std::uint64_t first_ns() const override { return bag_->first_ns(); }
  [[nodiscard]] std::uint64_t last_ns() const override { return bag_->last_ns(); }
  [[nodiscard]] std::unique_ptr<mcap::MessageCursor> messages(const mcap::Selection& selection) const override {
    return bag_->messages(selection);
  }
  [[nodiscard]] std::vector<std::string> damage() const override { return bag_->damage(); }

 private:
  std::unique_ptr<mcap::Bag> bag_;
  std::vector<mcap::Topic> topics_;
};

/// Throws InputError. Topics are compared in pairs: O(n²).
void check_number_of_topics(const std::string& name, const std::vector<mcap::Topic>& topics) {
  constexpr std::ptrdiff_t most_topics{1000};
  const auto of_cameras{std::ranges::count_if(
      topics, [](const mcap::Topic& topic) { return topic.message_count > 0 && is_of_camera(topic); })};
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

/// Places the camera by /tf_static. Throws InputError. `bag_name`, `images`: the left images' topic; for messages.
void place_in_vehicle(io::ForeignRecording& found, const mcap::Bag& bag, const BagFrames& frames,
                      const std::string& bag_name, const std::string& images) {
  TransformBuffer transforms;
  add_static_transforms(transforms, bag);
  const std::string place{
      place_camera(found.calibration.value(), transforms, frames.vehicle, frames.camera, bag_name + ", " + images)};
  found.notes.push_back(images + ": " + place);
}

/// Throws InputError: there are no images below the namespace.
std::unique_ptr<mcap::Bag> bag_of_camera(std::unique_ptr<mcap::Bag> bag, const std::string& name,
                                         const std::string& name_space) {
  std::vector<std::string> images;
  for (const mcap::Topic& topic : bag->topics()) {
    if (holds_images(topic)) images.push_back(io::printable(topic.name));
  }
  auto camera{std::make_unique<OneCamera>(std::move(bag), name_space)};
  if (std::ranges::any_of(camera->topics(), holds_images)) return camera;
  throw InputError{name,
                   fmt::format("has no images below {}. There are: {}.", io::printable(name_space),
                               images.empty() ? "none" : fmt::format("{}", fmt::join(images, ", "))),
                   "Name the stereo pairs' namespaces: --cameras /front,/rear."};
}

}  // namespace

std::string namespace_of(const std::string& root, std::string camera) {
  while (camera.ends_with('/')) camera.pop_back();
  return camera.starts_with('/') ? camera : root + '/' + camera;
}

bool is_bag(const fs::path& path) {
  if (!io::is_folder(path)) return is_bag_file(path);
  constexpr std::array<const char*, 10> of_others{"left",    "right",    "image_0",  "image_1",  "image_2",
                                                  "image_3", "image_00", "image_01", "image_02", "image_03"};
  if (std::ranges::any_of(of_others, [&](const char* name) { return io::is_folder(path / name); })) {
    return false;
  }
  if (io::is_there(path / "run.json")) return false;  // results, which may have a recording of them
  return io::is_there(path / "metadata.yaml") || std::ranges::any_of(io::entries_of(path), is_bag_file);
}

std::unique_ptr<io::Recording> bag_recording(std::unique_ptr<mcap::Bag> bag, const io::InputArguments& arguments,
                                             const BagOptions& options) {
  const fs::path& path{arguments.paths.front()};
  const std::string name{io::printable_path(path)};
  const bool is_placed{!arguments.cameras.empty()};
  if (is_placed) bag = bag_of_camera(std::move(bag), name, arguments.cameras.front());
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
  BagFrames frames;
  frames.camera = frame_of_first(opened, topics.left);
  take_poses(found, opened, arguments.poses, is_placed, frames);
  if (is_placed) place_in_vehicle(found, opened, frames, name, io::printable(topics.left));
  find_grids(found, *images, opened, options.grid_topic, frames.camera, frames.world);
  for (std::string& sentence : opened.damage()) found.warnings.push_back(std::move(sentence));
  found.images = std::move(images);
  return io::open_recording(arguments, std::move(found));
}

std::unique_ptr<io::Recording> open_recording(const io::InputArguments& arguments, const BagOptions& options) {
  const auto open = [&](const io::InputArguments& one) {
    return bag_recording(mcap::open_bag(one.paths.front()), one, options);
  };
  if (arguments.cameras.empty()) return open(arguments);
  if (arguments.calibration || arguments.mask || !options.topics.left.empty() || !options.topics.right.empty()) {
    throw ConfigError{
        "--calibration, --mask, --left-topic and --right-topic are of one camera, but --cameras lists namespaces."};
  }
  std::vector<std::string> namespaces;
  for (const std::string& camera : arguments.cameras) namespaces.push_back(namespace_of("", camera));
  return io::open_cameras(namespaces, [&](const std::string& name_space) {
    io::InputArguments one{arguments};
    one.cameras = {name_space};
    return open(one);
  });
}

}  // namespace stereogrid::rosbag
