// SPDX-License-Identifier: Apache-2.0
#include "images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stereogrid/error.hpp"
#include "stereogrid/io/ros_image.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::rosbag {
namespace {

namespace sensor_msgs = messages::sensor_msgs;
using messages::stereo_msgs::DisparityImage;

template <class Message>
Message decoded(std::span<const std::byte> cdr) {
  Message message;
  messages::decode(cdr, message);
  return message;
}

/// Between stamps of two cameras, which may be anything.
std::int64_t apart_ns(const Shot& a, const Shot& b) {
  const std::int64_t from{std::min(a.stamp_ns, b.stamp_ns)};
  const std::int64_t to{std::max(a.stamp_ns, b.stamp_ns)};
  return from < 0 && to > std::numeric_limits<std::int64_t>::max() + from ? std::numeric_limits<std::int64_t>::max()
                                                                          : to - from;
}

/// Index of the nearest one in time. `shots`: in their order, not empty.
std::size_t nearest(const std::vector<Shot>& shots, const Shot& to) {
  const auto after{std::ranges::lower_bound(shots, to.stamp_ns, {}, &Shot::stamp_ns)};
  const auto index{static_cast<std::size_t>(after - shots.begin())};
  if (index == 0) return 0;
  const bool is_before{after == shots.end() || apart_ns(shots[index - 1], to) <= apart_ns(*after, to)};
  return is_before ? index - 1 : index;
}

/// Takes those that have a partner of the very same stamp out of both.
std::vector<ShotPair> take_equal(std::vector<Shot>& left, std::vector<Shot>& right) {
  std::vector<ShotPair> pairs;
  std::vector<Shot> left_rest, right_rest;
  auto r{right.begin()};
  for (const Shot& l : left) {
    while (r != right.end() && r->stamp_ns < l.stamp_ns) right_rest.push_back(*r++);
    if (r != right.end() && r->stamp_ns == l.stamp_ns) {
      pairs.emplace_back(l, *r++);
    } else {
      left_rest.push_back(l);
    }
  }
  right_rest.insert(right_rest.end(), r, right.end());
  left = std::move(left_rest);
  right = std::move(right_rest);
  return pairs;
}

Image<std::uint8_t> part_of(const Image<std::uint8_t>& image, int first_u, int first_v, int width_px, int height_px) {
  Image<std::uint8_t> part{width_px, height_px};
  for (int v{0}; v < height_px; ++v) std::copy_n(image.row(first_v + v) + first_u, width_px, part.row(v));
  return part;
}

/// The left half, or the upper one, is the left image.
io::ImagePair halves_of(const io::ScaledImage& both, SecondTopic layout, const std::string& name) {
  const bool is_beside{layout == SecondTopic::beside};
  const int width_px{is_beside ? both.grey.width() / 2 : both.grey.width()};
  const int height_px{is_beside ? both.grey.height() : both.grey.height() / 2};
  if (width_px == 0 || height_px == 0 || (is_beside ? both.grey.width() : both.grey.height()) % 2 != 0) {
    throw InputError{name,
                     fmt::format("{}×{} px are not two images of one size.", both.grey.width(), both.grey.height()),
                     "Record the images of both cameras on topics of their own."};
  }
  return {part_of(both.grey, 0, 0, width_px, height_px),
          part_of(both.grey, is_beside ? width_px : 0, is_beside ? 0 : height_px, width_px, height_px), both.bits,
          both.bits};
}

}  // namespace

std::int64_t ns_of(const messages::builtin_interfaces::Time& stamp) {
  return stamp.sec * std::int64_t{1'000'000'000} + stamp.nanosec;
}

std::int64_t header_stamp_ns(std::span<const std::byte> cdr) {
  messages::CdrReader reader{cdr, sensor_msgs::Image::type_name};
  messages::std_msgs::Header header;
  reader("header", header);
  return ns_of(header.stamp);
}

io::ScaledImage decode_image(std::span<const std::byte> cdr, bool is_compressed, const std::string& name) {
  if (!is_compressed) return io::decode_ros_image(io::ros_image_of(decoded<sensor_msgs::Image>(cdr)), name);
  return io::decode_ros_image(io::ros_image_of(decoded<sensor_msgs::CompressedImage>(cdr)), name);
}

Image<float> decode_depth(std::span<const std::byte> cdr, const mcap::Topic& topic, const std::string& name) {
  if (topic.type == DisparityImage::type_name) {
    return io::decode_ros_disparities(io::ros_disparities_of(decoded<DisparityImage>(cdr)), name);
  }
  if (topic.type == sensor_msgs::CompressedImage::type_name) {
    return io::decode_ros_depth(io::ros_image_of(decoded<sensor_msgs::CompressedImage>(cdr)), name);
  }
  return io::decode_ros_depth(io::ros_image_of(decoded<sensor_msgs::Image>(cdr)), name);
}

double disparity_baseline_m(std::span<const std::byte> cdr) {
  const double baseline_m{std::abs(double{decoded<DisparityImage>(cdr).t})};
  return std::isfinite(baseline_m) ? baseline_m : 0;
}

double first_baseline_m(const mcap::Bag& bag, const std::string& topic) {
  const auto cursor{bag.messages({.topics = {topic}})};
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      return disparity_baseline_m(message->data);
    } catch (const InputError&) {
      continue;
    }
  }
  return 0;
}

Shots find_shots(const mcap::Bag& bag, const std::string& topic) {
  Shots found;
  const auto cursor{bag.messages({.topics = {topic}})};
  bool is_stamped{false};
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      const std::int64_t header_ns{header_stamp_ns(message->data)};
      is_stamped = is_stamped || header_ns != 0;
      found.shots.push_back({header_ns, header_ns, message->log_time_ns});
    } catch (const InputError&) {
      ++found.damaged;
    }
  }
  found.are_stamped = is_stamped;
  for (Shot& shot : found.shots) {
    constexpr std::uint64_t latest_ns{std::numeric_limits<std::int64_t>::max()};
    if (!is_stamped) shot.stamp_ns = static_cast<std::int64_t>(std::min(shot.log_ns, latest_ns));
  }
  std::ranges::stable_sort(found.shots, {}, &Shot::stamp_ns);
  return found;
}

std::vector<ShotPair> pair_up(const std::vector<Shot>& left, const std::vector<Shot>& right,
                              std::int64_t tolerance_ns) {
  std::vector<Shot> left_rest{left};
  std::vector<Shot> right_rest{right};
  std::vector<ShotPair> pairs{take_equal(left_rest, right_rest)};
  for (std::size_t i{0}; i < left_rest.size() && !right_rest.empty(); ++i) {
    const Shot& r{right_rest[nearest(right_rest, left_rest[i])]};
    if (apart_ns(left_rest[i], r) <= tolerance_ns && nearest(left_rest, r) == i) pairs.emplace_back(left_rest[i], r);
  }
  std::ranges::stable_sort(pairs, {}, [](const ShotPair& pair) { return pair.first.stamp_ns; });
  // an image that was recorded twice
  const auto is_same = [](const ShotPair& a, const ShotPair& b) { return a.first.stamp_ns == b.first.stamp_ns; };
  pairs.erase(std::unique(pairs.begin(), pairs.end(), is_same), pairs.end());
  return pairs;
}

BagImages::BagImages(std::unique_ptr<mcap::Bag> bag, std::string name, ImageTopics topics, std::vector<ShotPair> pairs)
    : bag_{std::move(bag)},
      name_{std::move(name)},
      topics_{std::move(topics)},
      left_{*find_topic(bag_->topics(), topics_.left)},
      right_{*find_topic(bag_->topics(), topics_.right)},
      pairs_{std::move(pairs)} {}

std::vector<std::byte> BagImages::bytes_of(const std::string& topic, const Shot& shot) const {
  const std::lock_guard lock{mutex_};
  const auto cursor{bag_->messages({.topics = {topic}, .first_ns = shot.log_ns, .last_ns = shot.log_ns})};
  while (const mcap::Message* const message{cursor->next()}) {
    if (header_stamp_ns(message->data) == shot.header_ns) return {message->data.begin(), message->data.end()};
  }
  throw InputError{name_, fmt::format("the message of {} ns on {} is gone.", shot.stamp_ns, topic),
                   "Was the recording changed meanwhile?"};
}

io::ImagePair BagImages::load(std::size_t index) const {
  const auto& [first, second]{pairs_.at(index)};
  const auto name_of = [&](const std::string& topic, const Shot& shot) {
    return fmt::format("{}, {}, stamp {} ns", name_, io::printable(topic), shot.stamp_ns);
  };
  const std::string name{name_of(topics_.left, first)};
  io::ScaledImage left{decode_image(bytes_of(topics_.left, first), is_compressed(left_), name)};
  if (topics_.is_one_topic()) return halves_of(left, topics_.second, name);
  const std::string second_name{name_of(topics_.right, second)};
  const std::vector<std::byte> bytes{bytes_of(topics_.right, second)};
  io::ImagePair pair{std::move(left.grey), {}, left.bits, left.bits};
  pair.has_other_byte_order = left.has_other_byte_order;
  if (topics_.has_depth()) {
    pair.depth_m =
        io::fit_depth(decode_depth(bytes, right_, second_name), pair.left.width(), pair.left.height(), second_name);
    return pair;
  }
  io::ScaledImage right{decode_image(bytes, is_compressed(right_), second_name)};
  pair.right = std::move(right.grey);
  pair.right_bits = right.bits;
  pair.has_other_byte_order |= right.has_other_byte_order;
  return pair;
}

std::optional<io::PlacedGrid> BagImages::load_grid(std::size_t index) const {
  const Shot& image{pairs_.at(index).first};
  const auto find = [&](const std::vector<Shot>& shots, const Shot& to) -> const Shot* {
    if (shots.empty()) return nullptr;
    const Shot& shot{shots[nearest(shots, to)]};
    return apart_ns(shot, to) <= grid_tolerance_ns ? &shot : nullptr;
  };
  const Shot* const cells{find(grids_.cells, image)};
  if (cells == nullptr) return std::nullopt;
  const std::string name{
      fmt::format("{}, {}, stamp {} ns", name_, io::printable(grids_.topics.cells), cells->stamp_ns)};
  const std::string& type{find_topic(bag_->topics(), grids_.topics.cells)->type};
  io::PlacedGrid grid{decode_grid(bytes_of(grids_.topics.cells, *cells), type, name)};
  if (const Shot* const graded{find(grids_.certainty, *cells)}) {
    set_certainty(grid, bytes_of(grids_.topics.certainty, *graded), name);
  }
  grid.vehicle_from_grid = grids_.base_from_grid * grid.vehicle_from_grid;
  grid.is_in_world = grids_.is_in_world;
  return grid;
}

void BagImages::find_sample_bits() {
  constexpr std::size_t looked_at{8};
  const std::size_t steps{std::min(looked_at, pairs_.size())};
  for (std::size_t i{1}; i < steps; ++i) {
    try {
      const io::ImagePair pair{load(i * (pairs_.size() - 1) / (steps - 1))};
      sample_bits_ = std::max({sample_bits_, pair.left_bits, pair.right_bits});
    } catch (const InputError&) {  // reported where the frame is loaded
    }
  }
}

io::ImagePair BagImages::begin() {
  constexpr std::size_t most_tried{15};
  std::string first_problem;
  for (std::size_t i{0}; i < std::min(most_tried, pairs_.size()); ++i) {
    try {
      io::ImagePair pair{load(i)};
      sample_bits_ = std::max(pair.left_bits, pair.right_bits);
      if (sample_bits_ > 8) find_sample_bits();
      return pair;
    } catch (const InputError& error) {
      if (first_problem.empty()) first_problem = error.what();
    }
  }
  throw InputError{name_, "none of the first images can be read.", first_problem};
}

}  // namespace stereogrid::rosbag
