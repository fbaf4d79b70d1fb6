// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sqlite3.h>

#include "../io/support.hpp"
#include "../prelude.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/mcap/reader.hpp"
#include "stereogrid/mcap/writer.hpp"

namespace stereogrid::mcap::testing {

namespace fs = std::filesystem;
using io::testing::expect_error;
using io::testing::TemporaryFolder;

/// A new file, where one of this name was, too: rewriting that one would wait for the disk.
void put(const fs::path& path, std::string_view bytes);

/// The specification's forms, written once more.
[[nodiscard]] std::string number(std::uint64_t value, int bytes);
[[nodiscard]] std::string text(std::string_view text);  ///< a string, an array or a map: its length before it
[[nodiscard]] std::string record(int op, std::string_view content);
[[nodiscard]] std::string message_record(int channel, int sequence, std::uint64_t log_ns, std::uint64_t publish_ns,
                                         std::string_view data);
[[nodiscard]] std::uint32_t crc(std::string_view bytes);
inline const std::string magic{"\x89MCAP0\r\n"};

/// A message as it is compared.
struct Said {
  std::string topic;
  std::uint32_t sequence{0};
  std::uint64_t log_ns{0}, publish_ns{0};
  std::string data;

  bool operator==(const Said&) const = default;
};

[[nodiscard]] std::string string_of(std::span<const std::byte> bytes);
inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span{text});
}
std::ostream& operator<<(std::ostream& out, const Said& said);

/// Three channels of two types, `count` messages of random times within a second around i · `step_ns`, of random sizes.
[[nodiscard]] std::vector<Said> random_messages(unsigned seed, int count, std::uint64_t step_ns = 10'000'000);

/// Writes them, and closes the file if `closes`.
void write_messages(const fs::path& path, const std::vector<Said>& messages, const WriterOptions& options = {});

[[nodiscard]] std::vector<Said> read_all(const Reader& reader, const Selection& selection = {});
/// All that a stream gives, and its damage.
[[nodiscard]] std::pair<std::vector<Said>, Damage> stream_all(const fs::path& path);
/// Stably sorted by log time.
[[nodiscard]] std::vector<Said> in_time(std::vector<Said> messages);

using ::testing::ElementsAre, ::testing::IsEmpty;

/// A file of SQLite that is made here.
class NewDatabase {
 public:
  explicit NewDatabase(const fs::path& path) {
    fs::create_directories(path.parent_path());
    EXPECT_EQ(sqlite3_open(path.c_str(), &database_), SQLITE_OK);
  }
  NewDatabase(const NewDatabase&) = delete;
  NewDatabase& operator=(const NewDatabase&) = delete;
  ~NewDatabase() { sqlite3_close(database_); }

  void run(const std::string& sql) const {
    EXPECT_EQ(sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database_);
  }
  void add_message(int topic, std::int64_t time_ns, std::string_view data) const {
    sqlite3_stmt* statement{nullptr};
    sqlite3_prepare_v2(database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &statement,
                       nullptr);
    sqlite3_bind_int(statement, 1, topic);
    sqlite3_bind_int64(statement, 2, time_ns);
    sqlite3_bind_blob(statement, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE) << sqlite3_errmsg(database_);
    sqlite3_finalize(statement);
  }

 private:
  sqlite3* database_{nullptr};
};

/// The tables of rosbag2 in ROS 2 Humble, with topics 1: /a, 2: /b.
inline const std::string tables{
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
    "INSERT INTO schema VALUES(3, 'humble');"
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT "
    "NULL, offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
    "NOT "
    "NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
    "INSERT INTO topics VALUES(1, '/a', 'std_msgs/msg/String', 'cdr', '- history: 1');"
    "INSERT INTO topics VALUES(2, '/b', 'std_msgs/msg/Int8', 'cdr', '');"};

inline void write_db3(const fs::path& path, const std::vector<std::tuple<int, std::int64_t, std::string>>& messages) {
  const NewDatabase database{path};
  database.run(tables + "BEGIN");
  for (const auto& [topic, time_ns, data] : messages) database.add_message(topic, time_ns, data);
  database.run("COMMIT");
}

using ReadMessage = std::tuple<std::string, std::uint64_t, std::string>;

inline std::vector<ReadMessage> read_all(const Bag& bag, const Selection& selection = {}) {
  std::vector<ReadMessage> all;
  const auto cursor{bag.messages(selection)};
  while (const Message* const message{cursor->next()}) {
    all.emplace_back(bag.topics().at(message->channel).name, message->log_time_ns, string_of(message->data));
  }
  return all;
}

}  // namespace stereogrid::mcap::testing
