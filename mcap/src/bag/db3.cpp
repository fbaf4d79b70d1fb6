// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "bag/bags.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::mcap {
namespace {

constexpr std::uint64_t latest_ns{std::numeric_limits<std::int64_t>::max()};

/// Topics of a file of rosbag2 by the ids of its rows.
using TopicIds = std::map<std::int64_t, std::uint16_t>;

std::uint64_t time_of(const Database& database, const Statement& row, int column) {
  if (row.is_integer(column) && row.integer(column) >= 0) return static_cast<std::uint64_t>(row.integer(column));
  throw InputError{database.name(), "a message has no time, or one before 1970.", "Was the recording made by rosbag2?"};
}

/// Rows in the order of time first, the data of each afterwards: without an index on the time SQLite would have to sort
/// the data as well.
class Db3Cursor : public MessageCursor {
 public:
  Db3Cursor(const Database& database, const TopicIds& wanted, const Selection& selection)
      : database_{database},
        wanted_{wanted},
        rows_{database.prepare("SELECT rowid, topic_id, timestamp FROM messages WHERE timestamp BETWEEN ?1 AND ?2 "
                               "ORDER BY timestamp, rowid")},
        data_{database.prepare("SELECT data FROM messages WHERE rowid = ?1")} {
    rows_.bind(1, static_cast<std::int64_t>(std::min(selection.first_ns, latest_ns)));
    rows_.bind(2, static_cast<std::int64_t>(std::min(selection.last_ns, latest_ns)));
    is_empty_ = selection.first_ns > latest_ns;
  }

  const Message* next() override {
    while (!is_empty_ && rows_.step()) {
      const auto topic{wanted_.find(rows_.integer(1))};
      if (topic == wanted_.end()) continue;
      data_.reset();
      data_.bind(1, rows_.integer(0));
      if (!data_.step()) database_.fail();
      const std::uint64_t time_ns{time_of(database_, rows_, 2)};
      if (time_ns < message_.log_time_ns) {
        throw InputError{database_.name(), "its index of times is damaged.", "Make it anew: sqlite3 FILE REINDEX"};
      }
      message_ = {topic->second, sequence_++, time_ns, time_ns, data_.bytes(0)};
      return &message_;
    }
    is_empty_ = true;
    return nullptr;
  }

 private:
  const Database& database_;
  TopicIds wanted_;
  Statement rows_, data_;
  bool is_empty_{false};
  std::uint32_t sequence_{0};
  Message message_;
};

class Db3Bag : public Bag {
 public:
  explicit Db3Bag(const std::filesystem::path& path) : database_{path}, topics_{database_.name()} {
    for (const char* const column : {"id", "name", "type", "serialization_format"}) require("topics", column);
    for (const char* const column : {"topic_id", "timestamp", "data"}) require("messages", column);
    read_topics();
    count_messages();
  }

  [[nodiscard]] const std::vector<Topic>& topics() const override { return topics_.all(); }
  [[nodiscard]] std::uint64_t first_ns() const override { return first_ns_; }
  [[nodiscard]] std::uint64_t last_ns() const override { return last_ns_; }

  [[nodiscard]] std::unique_ptr<MessageCursor> messages(const Selection& selection) const override {
    TopicIds wanted{ids_};
    std::erase_if(wanted, [&](const auto& id) {
      return !selection.topics.empty() &&
             std::ranges::find(selection.topics, topics_.all()[id.second].name) == selection.topics.end();
    });
    return std::make_unique<Db3Cursor>(database_, wanted, selection);
  }

  [[nodiscard]] std::vector<std::string> damage() const override { return {}; }  // such a file throws

 private:
  void require(const char* table, const char* column) const {
    if (database_.has_column(table, column)) return;
    throw InputError{database_.name(), fmt::format("is SQLite, but has no column '{}' in a table '{}'.", column, table),
                     "Name a .db3 that rosbag2 has written."};
  }

  void read_topics() {
    const bool has_qos{database_.has_column("topics", "offered_qos_profiles")};  // since ROS 2 Foxy
    Statement rows{
        database_.prepare(fmt::format("SELECT id, name, type, serialization_format, {} FROM topics ORDER BY id",
                                      has_qos ? "offered_qos_profiles" : "''"))};
    const std::map<std::string, std::pair<std::string, std::string>> definitions{read_definitions()};
    while (rows.step()) {
      Topic topic;
      topic.name = rows.text(1);
      topic.type = rows.text(2);
      topic.message_encoding = rows.text(3);
      topic.offered_qos_profiles = rows.text(4);
      if (const auto found{definitions.find(topic.type)}; found != definitions.end()) {
        std::tie(topic.schema_encoding, topic.schema) = found->second;
      }
      ids_[rows.integer(0)] = topics_.add(topic);
    }
  }

  void count_messages() {
    Statement rows{database_.prepare("SELECT topic_id, timestamp FROM messages")};
    bool is_first{true};
    while (rows.step()) {
      const auto topic{ids_.find(rows.integer(0))};
      if (topic == ids_.end()) continue;
      topics_.count_message(topic->second);
      const std::uint64_t time_ns{time_of(database_, rows, 1)};
      first_ns_ = is_first ? time_ns : std::min(first_ns_, time_ns);
      last_ns_ = std::max(last_ns_, time_ns);
      is_first = false;
    }
  }

  /// Encoding and text by type. Since ROS 2 Iron.
  [[nodiscard]] std::map<std::string, std::pair<std::string, std::string>> read_definitions() const {
    std::map<std::string, std::pair<std::string, std::string>> definitions;
    if (!database_.has_column("message_definitions", "encoded_message_definition")) return definitions;
    Statement rows{
        database_.prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")};
    while (rows.step()) definitions.insert_or_assign(rows.text(0), std::pair{rows.text(1), rows.text(2)});
    return definitions;
  }

  Database database_;
  TopicList topics_;
  TopicIds ids_;
  std::uint64_t first_ns_{0}, last_ns_{0};
};

}  // namespace

std::unique_ptr<Bag> open_db3_bag(const std::filesystem::path& path) {
  return std::make_unique<Db3Bag>(path);
}

}  // namespace stereogrid::mcap
