// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::mcap::testing {
namespace {

using Bag = FolderTest;

TEST_F(Bag, ReadsDb3InTimeWithTopicsAndCounts) {
  write_db3(folder / "a.db3", {{1, 30, "three"}, {2, 10, "one"}, {1, 20, ""}, {2, 30, "four"}});
  const auto bag{open_bag(folder / "a.db3")};
  ASSERT_EQ(bag->topics().size(), 2);
  EXPECT_EQ(bag->topics()[0].name, "/a");
  EXPECT_EQ(bag->topics()[0].type, "std_msgs/msg/String");
  EXPECT_EQ(bag->topics()[0].message_encoding, "cdr");
  EXPECT_EQ(bag->topics()[0].offered_qos_profiles, "- history: 1");
  EXPECT_EQ(bag->topics()[1].message_count, 2);
  EXPECT_EQ(bag->first_ns(), 10);
  EXPECT_EQ(bag->last_ns(), 30);
  EXPECT_THAT(read_all(*bag), ElementsAre(ReadMessage{"/b", 10, "one"}, ReadMessage{"/a", 20, ""},
                                          ReadMessage{"/a", 30, "three"}, ReadMessage{"/b", 30, "four"}));
  EXPECT_THAT(read_all(*bag, {.topics = {"/a"}}),
              ElementsAre(ReadMessage{"/a", 20, ""}, ReadMessage{"/a", 30, "three"}));
  EXPECT_THAT(read_all(*bag, {.first_ns = 11, .last_ns = 20}), ElementsAre(ReadMessage{"/a", 20, ""}));
  EXPECT_THAT(read_all(*bag, {.first_ns = ~std::uint64_t{0}}), IsEmpty());
  EXPECT_THAT(bag->damage(), IsEmpty());
}

TEST_F(Bag, ReadsDb3OfOtherVersionsOfRos) {
  {
    const NewDatabase old{folder / "dashing.db3"};
    old.run(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
        "INSERT INTO topics VALUES(5, '/a', 'T', 'cdr');");
    old.add_message(5, 1, "x");
    old.add_message(6, 1, "of a topic that is not declared");
    const NewDatabase later{folder / "iron.db3"};
    later.run(tables +
              "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT "
              "NULL, encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);"
              "INSERT INTO message_definitions VALUES(1, 'std_msgs/msg/String', 'ros2msg', 'string data', '');");
  }
  EXPECT_THAT(read_all(*open_bag(folder / "dashing.db3")), ElementsAre(ReadMessage{"/a", 1, "x"}));
  const auto bag{open_bag(folder / "iron.db3")};
  EXPECT_EQ(bag->topics()[0].schema, "string data");
  EXPECT_EQ(bag->topics()[0].schema_encoding, "ros2msg");
  EXPECT_EQ(bag->topics()[1].schema_encoding, "");
}

TEST_F(Bag, NamesOfFilesMayHaveAnyCharacter) {
  const fs::path path{folder / "a%20b?mode=rw#ü\xff.db3"};
  write_db3(path, {{1, 30, "x"}});
  EXPECT_EQ(read_all(*open_bag(path)).size(), 1);
}

/// A journal beside the file belongs to it, and reading changes neither.
TEST_F(Bag, ReadsWhatIsInTheJournalOnly) {
  const NewDatabase open{folder / "a.db3"};
  open.run("PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0;" + tables);
  open.add_message(1, 7, "in the journal");
  ASSERT_GT(fs::file_size(folder / "a.db3-wal"), 0);
  fs::create_directory(folder / "copy");
  for (const char* const name : {"a.db3", "a.db3-wal"}) fs::copy(folder / name, folder / "copy" / name);
  EXPECT_THAT(read_all(*open_bag(folder / "copy" / "a.db3")), ElementsAre(ReadMessage{"/a", 7, "in the journal"}));
  EXPECT_EQ(io::read_file(folder / "copy" / "a.db3"), io::read_file(folder / "a.db3"));
}

TEST_F(Bag, LeavesNothingBesideAFile) {
  write_db3(folder / "a.db3", {{1, 30, "x"}});
  fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
  read_all(*open_bag(folder / "a.db3"));
  fs::permissions(folder.path(), fs::perms::owner_all);
  EXPECT_EQ(std::distance(fs::directory_iterator{folder.path()}, fs::directory_iterator{}), 1);
}

TEST_F(Bag, RejectsOtherDatabases) {
  const auto expect_rejected = [&](const std::string& sql, std::string_view part) {
    fs::remove(folder / "a.db3");
    {
      const NewDatabase database{folder / "a.db3"};
      database.run(sql);
    }
    expect_error([&] { read_all(*open_bag(folder / "a.db3")); }, {"a.db3", part});
  };
  const std::string topics{
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
      "INSERT INTO topics VALUES(1, '/a', 'T', 'cdr');"};
  expect_rejected("CREATE TABLE x(y)", "has no column 'id' in a table 'topics'");
  expect_rejected(topics, "has no column 'topic_id' in a table 'messages'");
  expect_rejected(topics + "CREATE TABLE messages(topic_id, timestamp)", "has no column 'data'");
  expect_rejected(
      topics + "CREATE TABLE messages(topic_id, timestamp, data); INSERT INTO messages VALUES(1, 'noon', 'x')",
      "has no time");
  expect_rejected(topics + "CREATE TABLE messages(topic_id, timestamp, data); INSERT INTO messages VALUES(1, -5, 'x')",
                  "before 1970");
  // definitions that compute: without end, or as much as they like
  expect_rejected(topics +
                      "CREATE VIEW messages AS WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM r) "
                      "SELECT 1 AS topic_id, i AS timestamp, 'x' AS data FROM r",
                  "has no column 'topic_id' in a table 'messages'");
  expect_rejected(topics + "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)",
                  "has no column 'topic_id' in a table 'messages'");
}

TEST_F(Bag, ADamagedDb3IsRejected) {
  std::vector<std::tuple<int, std::int64_t, std::string>> messages;
  for (int i{0}; i < 50; ++i) messages.emplace_back(1 + i % 2, i, std::string(300, static_cast<char>(i)));
  write_db3(folder / "a.db3", messages);
  const std::string bytes{io::read_file(folder / "a.db3")};
  int errors{0};
  for (std::size_t cut{16}; cut < bytes.size(); cut += 997) {
    put(folder / "cut.db3", bytes.substr(0, cut));
    try {
      EXPECT_EQ(read_all(*open_bag(folder / "cut.db3")).size(), 50) << cut << ": nothing that is needed is lost";
    } catch (const InputError&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 35);
  errors = 0;
  for (std::size_t at{0}; at < bytes.size(); at += 101) {
    std::string broken{bytes};
    broken[at] = static_cast<char>(~broken[at]);
    put(folder / "broken.db3", broken);
    try {
      EXPECT_LE(read_all(*open_bag(folder / "broken.db3")).size(), 70) << at;
    } catch (const InputError&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 5);
}

}  // namespace
}  // namespace stereogrid::mcap::testing
