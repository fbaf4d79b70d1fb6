// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros2_source.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;

constexpr auto look_every{50ms};
constexpr auto log_after{2s};
constexpr auto log_every{10s};

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto settled_after{500ms};  // image_raw may be found before image_rect
constexpr auto silent_after{2s};      // for topics that are not chosen

std::string list_of(const std::vector<mcap::Topic>& topics) {
  std::string list;
  for (const mcap::Topic& topic : topics) list += (list.empty() ? "" : ", ") + io::printable(topic.name);
  return list;
}

bool has_name_of_images(const mcap::Topic& topic) {
  return topic.name.find("image") != std::string::npos;
}

bool is_depth(const mcap::Topic& topic) {
  return rosbag::depth_kind_of(topic, {}).has_value();
}

/// Encodings of the images that have come. `topics`: those without one yet.
struct Seen {
  rosbag::Encodings encodings;
  std::vector<std::string> silent;
};

Seen look_at(NewestMessages& messages, const std::vector<mcap::Topic>& topics, const rosbag::ImageTopics& asked) {
  const bool are_asked{!asked.left.empty() && !asked.right.empty()};
  Seen seen;
  for (const mcap::Topic& topic : topics) {
    if (topic.type != messages::sensor_msgs::Image::type_name) continue;
    if (are_asked && topic.name != asked.left && topic.name != asked.right) continue;
    messages.add(topic);
    try {
      messages::sensor_msgs::Image image;
      messages::decode(messages.of(topic.name).value_or(std::vector<std::byte>{}), image);
      seen.encodings[topic.name] = image.encoding;
    } catch (const InputError&) {
      seen.silent.push_back(topic.name);
    }
  }
  return seen;
}

/// Throws InputError if there is no such pair; the message lists the topics found.
rosbag::ImageTopics choose(const std::string& name, const std::vector<mcap::Topic>& topics,
                           const rosbag::ImageTopics& asked, const rosbag::Encodings& encodings,
                           const std::string& elsewhere) {
  if (std::ranges::none_of(topics, rosbag::holds_images)) {
    std::vector<mcap::Topic> depth;
    std::ranges::copy_if(topics, std::back_inserter(depth), is_depth);
    const std::string hint{elsewhere.empty() ? "" : " Elsewhere there are: " + elsewhere + "."};
    if (!depth.empty()) {
      throw InputError{name, fmt::format("there is depth on {}, but images have no publisher.", list_of(depth)),
                       "Give the left camera's images: --left-topic TOPIC --right-topic TOPIC (the depth)." + hint};
    }
    if (const auto named{std::ranges::find_if(topics, has_name_of_images)}; named != topics.end()) {
      throw InputError{
          name, fmt::format("images have no publisher: {} is of type {}.", io::printable(named->name), named->type),
          "Publish sensor_msgs/msg/Image or CompressedImage." + hint};
    }
    throw InputError{name, "images have no publisher.",
                     hint.empty() ? "Check ROS_DOMAIN_ID and the network." : hint.substr(1)};
  }
  rosbag::ImageTopics chosen{rosbag::choose_image_topics(name, topics, asked, encodings)};
  if (!chosen.is_one_topic()) return chosen;
  throw InputError{name,
                   fmt::format("the only images are {}: right images or depth are missing, and both images in one are "
                               "not read live.",
                               chosen.left),
                   "Publish them, or say which: --left-topic TOPIC --right-topic TOPIC."};
}

/// Names of the topics whose images have to come before the choice counts; empty: it does.
std::string missing_of(const Seen& seen, const rosbag::ImageTopics& chosen, Clock::duration since) {
  std::string missing;
  for (const std::string& topic : seen.silent) {
    const bool is_chosen{topic == chosen.left || topic == chosen.right};
    if (is_chosen || since < silent_after) missing += (missing.empty() ? "" : ", ") + io::printable(topic);
  }
  return missing;
}

}  // namespace

void Waiting::print(const std::string& sentence) {
  const Clock::time_point now{Clock::now()};
  if (sentence != sentence_) {
    sentence_ = sentence;
    next_log_ = now + log_after;
  } else if (now > next_log_) {
    spdlog::warn("waiting: {}", sentence);
    next_log_ = now + log_every;
  }
  std::this_thread::sleep_for(look_every);
}

NewestMessages::~NewestMessages() {
  std::map<std::string, std::vector<std::byte>> messages;
  {
    const std::scoped_lock lock{state_->mutex};
    messages.swap(state_->messages);
  }
  for (const auto& [topic, ignored] : messages) node_.unsubscribe(topic);
}

void NewestMessages::add(const mcap::Topic& topic) {
  {
    const std::scoped_lock lock{state_->mutex};
    if (!state_->messages.try_emplace(topic.name).second) return;
  }
  node_.subscribe(topic.name, topic.type, 1, [state = state_, name = topic.name](std::span<const std::byte> cdr) {
    const std::scoped_lock lock{state->mutex};
    const auto found{state->messages.find(name)};
    if (found != state->messages.end()) found->second.assign(cdr.begin(), cdr.end());
  });
}

std::optional<std::vector<std::byte>> NewestMessages::of(const std::string& topic) const {
  const std::scoped_lock lock{state_->mutex};
  const auto found{state_->messages.find(topic)};
  if (found == state_->messages.end() || found->second.empty()) return std::nullopt;
  return found->second;
}

std::vector<mcap::Topic> topics_of(const dds::Node& node, const InputOptions& options, std::string* elsewhere) {
  std::string folder{options.paths.front().substr(ros2_scheme.size())};
  while (folder.ends_with('/')) folder.pop_back();
  std::vector<mcap::Topic> topics;
  std::vector<mcap::Topic> others;
  for (const dds::PublishedTopic& topic : node.topics()) {
    mcap::Topic one;
    one.name = topic.name;
    one.type = topic.type;
    one.message_count = 1;
    const bool is_below{topic.name.starts_with(folder + "/")};
    if (!is_below && (rosbag::holds_images(one) || is_depth(one))) others.push_back(one);
    if (is_below || !options.left_topic.empty() || !options.right_topic.empty() ||
        (!options.grid_topic.empty() && topic.name.starts_with(options.grid_topic))) {
      topics.push_back(std::move(one));
    }
  }
  if (elsewhere != nullptr) *elsewhere = list_of(others);
  return topics;
}

FoundImages wait_for_images(dds::Node& node, const InputOptions& options) {
  const std::string& name{options.paths.front()};
  const rosbag::ImageTopics asked{options.left_topic, options.right_topic};
  Waiting waiting;
  NewestMessages messages{node};
  Seen seen;
  rosbag::ImageTopics last;
  Clock::time_point since{Clock::now()};
  for (;;) {
    std::string missing{"for all topics to be found."};
    std::string elsewhere;
    const std::vector<mcap::Topic> topics{topics_of(node, options, &elsewhere)};
    bool is_pair{false};
    try {
      const rosbag::ImageTopics chosen{choose(name, topics, asked, seen.encodings, elsewhere)};
      is_pair = chosen.second == rosbag::SecondTopic::right && asked.right.empty();
      if (chosen.left != last.left || chosen.right != last.right || chosen.second != last.second) since = Clock::now();
      last = chosen;
      const std::string silent{is_pair ? "" : missing_of(seen, chosen, Clock::now() - since)};
      if (!silent.empty()) missing = fmt::format("{}: no image has come on {}.", name, silent);
      if (silent.empty() && Clock::now() - since >= settled_after) {
        return {chosen, *rosbag::find_topic(topics, chosen.left), *rosbag::find_topic(topics, chosen.right)};
      }
    } catch (const InputError& error) {
      missing = error.what();
    }
    if (!is_pair) seen = look_at(messages, topics, asked);  // pairs are found by names alone
    waiting.print(missing);
  }
}

}  // namespace stereogrid::app
