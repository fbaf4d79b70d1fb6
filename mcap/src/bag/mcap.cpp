// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <string>

#include "bag/bags.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/mcap/reader.hpp"

namespace stereogrid::mcap {
namespace {

constexpr std::size_t channels_max{std::size_t{std::numeric_limits<std::uint16_t>::max()} + 1};

class McapBag : public Bag {
 public:
  explicit McapBag(const std::filesystem::path& path)
      : name_{io::printable_path(path)}, reader_{path}, topics_{name_}, topic_of_channel_(channels_max) {
    const Contents& contents{reader_.contents()};
    for (const auto& [id, channel] : contents.channels) {
      Topic topic;
      topic.name = channel.topic;
      topic.message_encoding = channel.message_encoding;
      if (const auto found{contents.schemas.find(channel.schema_id)}; found != contents.schemas.end()) {
        topic.type = found->second.name;
        topic.schema_encoding = found->second.encoding;
        topic.schema = found->second.data;
      }
      if (const auto found{channel.metadata.find("offered_qos_profiles")}; found != channel.metadata.end()) {
        topic.offered_qos_profiles = found->second;
      }
      const auto count{contents.message_counts.find(id)};
      topic.message_count = count == contents.message_counts.end() ? 0 : count->second;
      topic_of_channel_[id] = topics_.add(topic);
    }
  }

  [[nodiscard]] const std::vector<Topic>& topics() const override { return topics_.all(); }
  [[nodiscard]] std::uint64_t first_ns() const override { return reader_.contents().first_ns; }
  [[nodiscard]] std::uint64_t last_ns() const override { return reader_.contents().last_ns; }

  [[nodiscard]] std::unique_ptr<MessageCursor> messages(const Selection& selection) const override {
    return std::make_unique<Renumbered>(reader_.messages(selection), topic_of_channel_);
  }

  [[nodiscard]] std::vector<std::string> damage() const override {
    std::vector<std::string> sentences;
    for (const std::string& sentence : reader_.damage().sentences) sentences.push_back(name_ + ": " + sentence);
    return sentences;
  }

 private:
  std::string name_;
  Reader reader_;
  TopicList topics_;
  std::vector<std::uint16_t> topic_of_channel_;
};

}  // namespace

std::unique_ptr<Bag> open_mcap_bag(const std::filesystem::path& path) {
  return std::make_unique<McapBag>(path);
}

}  // namespace stereogrid::mcap
