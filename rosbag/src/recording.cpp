// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/recording.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "images.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/rosbag/calibration.hpp"
#include "stereogrid/rosbag/poses.hpp"

namespace stereogrid::rosbag {
namespace {

namespace fs = std::filesystem;

bool is_bag_file(const fs::path& path) {
  return path.extension() == ".mcap" || path.extension() == ".db3";
}

/// What was not used, and why.
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
    throw InputError{name, fmt::format("all {} messages on {} are damaged.", shots->damaged, io::printable(*topic)),
                     "Record them again."};
  }
  throw InputError{
      name,
      fmt::format("none of the {} images on {} and {} on {} are of the same instant, to {:g} ms.", left.shots.size(),
                  io::printable(topics.left), right.shots.size(), io::printable(topics.right), tolerance_ms),
      "Are the cameras triggered together? --pair-tolerance-ms MS allows for more."};
}

/// Poses of the bag, unless most of them were dropped: what is left of such a topic has gaps.
void take_poses(io::ForeignRecording& found, const mcap::Bag& bag, const std::string& wanted) {
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
    found.poses = std::move(poses.poses);
    if (!poses.others.empty()) found.notes.push_back(fmt::format("poses: not taken:{}", poses.others));
  } else if (tally.poses == 0) {
    found.poses_source +=
        fmt::format(" is not there{}{}", tally.transforms.empty() ? "" : ", only ", fmt::join(tally.transforms, ", "));
  } else if (dropped.empty()) {
    found.poses_source += ": too few poses, two stamps are needed";
  }
}

}  // namespace

bool is_bag(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return is_bag_file(path);
  constexpr std::array<const char*, 10> of_others{"left",    "right",    "image_0",  "image_1",  "image_2",
                                                  "image_3", "image_00", "image_01", "image_02", "image_03"};
  if (std::ranges::any_of(of_others, [&](const char* name) { return fs::is_directory(path / name, error); })) {
    return false;
  }
  if (fs::exists(path / "metadata.yaml", error)) return true;
  for (fs::directory_iterator entry{path, error}; !error && entry != fs::directory_iterator{}; entry.increment(error)) {
    if (is_bag_file(entry->path())) return true;
  }
  return false;
}

std::unique_ptr<io::Recording> bag_recording(std::unique_ptr<mcap::Bag> bag, const io::InputArguments& arguments,
                                             const BagOptions& options) {
  const fs::path& path{arguments.paths.front()};
  const std::string name{io::printable_path(path)};
  const mcap::Bag& opened{*bag};
  const ImageTopics topics{choose_image_topics(name, bag->topics(), options.topics)};
  const Shots left{find_shots(*bag, topics.left)};
  const Shots right{find_shots(*bag, topics.right)};
  std::vector<ShotPair> pairs{pairs_of(name, topics, left, right, options.pair_tolerance_ms)};
  io::ForeignRecording found;
  found.kind = fmt::format("ROS 2 bag, {} and {}", io::printable(topics.left), io::printable(topics.right));
  found.root = path;
  for (const ShotPair& pair : pairs) found.stamps_ns.push_back(pair.first.stamp_ns);
  warn_of_rest(found, topics, left, right, options.pair_tolerance_ms);
  auto images{std::make_unique<BagImages>(std::move(bag), name, topics, std::move(pairs))};
  const io::ImagePair first{images->begin()};
  found.width_px = first.left.width();
  found.height_px = first.left.height();
  found.sample_bits = images->sample_bits();
  if (!arguments.calibration) {
    found.calibration = calibration_of(opened, name, topics, found.width_px, found.height_px);
  }
  take_poses(found, opened, arguments.poses);
  for (std::string& sentence : opened.damage()) found.warnings.push_back(std::move(sentence));
  found.images = std::move(images);
  return io::open_recording(arguments, std::move(found));
}

std::unique_ptr<io::Recording> open_recording(const io::InputArguments& arguments, const BagOptions& options) {
  return bag_recording(mcap::open_bag(arguments.paths.front()), arguments, options);
}

}  // namespace stereogrid::rosbag
