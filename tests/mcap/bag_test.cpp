// SPDX-License-Identifier: Apache-2.0
#include <zstd.h>

#include "bag/bags.hpp"
#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::mcap::testing {
namespace {

using Bag = FolderTest;

const std::string metadata_begin{"rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"};

TEST_F(Bag, ReadsAFolderOfParts) {
  write_db3(folder / "bag" / "bag_0.db3", {{1, 1, "a"}, {2, 5, "c"}});
  write_db3(folder / "bag" / "bag_1.db3", {{1, 4, "b"}, {1, 9, "e"}});
  write_messages(folder / "bag" / "bag_2.mcap", {{"/c", 0, 7, 7, "d"}, {"/a", 0, 12, 12, "f"}});
  put(folder / "bag" / "metadata.yaml", metadata_begin +
                                            "  relative_file_paths:\n    - bag_0.db3\n    - bag/bag_1.db3\n"
                                            "    - bag_2.mcap\n  compression_mode: \"\"\n");
  const std::vector<ReadMessage> all{{"/a", 1, "a"}, {"/a", 4, "b"}, {"/b", 5, "c"},
                                     {"/c", 7, "d"}, {"/a", 9, "e"}, {"/a", 12, "f"}};
  const auto bag{open_bag(folder / "bag")};
  EXPECT_EQ(read_all(*bag), all);
  EXPECT_EQ(bag->topics()[0].message_count, 4) << "in all parts";
  EXPECT_EQ(bag->first_ns(), 1);
  EXPECT_EQ(bag->last_ns(), 12);
  EXPECT_THAT(read_all(*bag, {.topics = {"/b", "/c"}}), ElementsAre(all[2], all[3]));
  fs::remove(folder / "bag" / "metadata.yaml");
  EXPECT_EQ(read_all(*open_bag(folder / "bag")), all) << "as rosbag2 leaves it when it is killed";
}

std::string zstd(const std::string& text) {
  std::string packed(ZSTD_compressBound(text.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 1));
  return packed;
}

TEST_F(Bag, UnpacksMessagesThatRosbag2HasCompressedOneByOne) {
  write_db3(folder / "bag_0.db3", {{1, 1, zstd("first")}, {1, 2, zstd(std::string(100'000, 'x'))}, {1, 3, zstd("")}});
  put(folder / "metadata.yaml",
      metadata_begin + "  compression_format: zstd\n  compression_mode: MESSAGE\n  relative_file_paths: [bag_0.db3]\n");
  EXPECT_THAT(read_all(*open_bag(folder.path())),
              ElementsAre(ReadMessage{"/a", 1, "first"}, ReadMessage{"/a", 2, std::string(100'000, 'x')},
                          ReadMessage{"/a", 3, ""}));
  write_db3(folder / "bag_1.db3", {{1, 1, "not packed"}});
  put(folder / "metadata.yaml",
      metadata_begin + "  compression_format: zstd\n  compression_mode: MESSAGE\n  relative_file_paths: [bag_1.db3]\n");
  EXPECT_THAT(read_all(*open_bag(folder.path())), IsEmpty());
}

TEST_F(Bag, AMessageThatCannotBeUnpackedIsSkipped) {
  write_db3(folder / "bag_0.db3", {{1, 1, zstd("first")}, {1, 2, "no zstd"}, {1, 3, zstd("third")}});
  put(folder / "metadata.yaml",
      metadata_begin + "  compression_format: zstd\n  compression_mode: MESSAGE\n  relative_file_paths: [bag_0.db3]\n");
  const auto bag{open_bag(folder.path())};
  for (int round{0}; round < 2; ++round) {
    EXPECT_THAT(read_all(*bag), ElementsAre(ReadMessage{"/a", 1, "first"}, ReadMessage{"/a", 3, "third"}));
  }
  EXPECT_THAT(bag->damage(), ElementsAre(::testing::HasSubstr("The message of 2 ns is skipped")));
}

TEST_F(Bag, TensOfThousandsOfTopicsTakeNoLongerThanTheyMust) {
  const auto start{std::chrono::steady_clock::now()};
  const auto topics{[](int count) {
    return "WITH RECURSIVE c(x) AS (SELECT 3 UNION ALL SELECT x + 1 FROM c WHERE x < " + std::to_string(count) +
           ") INSERT INTO topics SELECT x, '/t' || x, 'a/msg/B', 'cdr', '' FROM c;";
  }};
  NewDatabase{folder / "many.db3"}.run(tables + topics(65'536));
  EXPECT_EQ(open_bag(folder / "many.db3")->topics().size(), 65'536);
  NewDatabase{folder / "too_many.db3"}.run(tables + topics(65'537));
  expect_error([&] { return open_bag(folder / "too_many.db3"); }, {"too_many.db3", "more than 65536 topics"});
  std::string channels{magic + record(1, text("ros2") + text(""))};
  for (int i{1}; i < 65'000; ++i) {
    channels += record(4, number(static_cast<std::uint64_t>(i), 2) + number(0, 2) + text("/t" + std::to_string(i)) +
                              text("cdr") + text(""));
  }
  put(folder / "many.mcap", channels + record(15, number(0, 4)) + record(2, std::string(20, '\0')) + magic);
  EXPECT_EQ(open_bag(folder / "many.mcap")->topics().size(), 64'999);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds{20}) << "once 100 s and more";
}

/// Schema `id` of `size` zeros, and a channel of it, in a compressed chunk.
std::string chunk_of_schema(int id, std::size_t size) {
  const std::string number_of_id{number(static_cast<std::uint64_t>(id), 2)};
  const std::string records{record(3, number_of_id + text("a") + text("b") + text(std::string(size, '\0'))) +
                            record(4, number_of_id + number_of_id + text("/t") + text("cdr") + text(""))};
  const std::string packed{zstd(records)};
  return record(6, number(0, 8) + number(9, 8) + number(records.size(), 8) + number(0, 4) + text("zstd") +
                       number(packed.size(), 8) + packed);
}

TEST_F(Bag, WhatAFileDeclaresIsBounded) {
  constexpr std::size_t size{std::size_t{20} << 20};
  std::string bytes{magic + record(1, text("ros2") + text(""))};
  for (int id{1}; id <= 5; ++id) bytes += chunk_of_schema(id, size);
  put(folder / "a.mcap", bytes + magic);
  const Reader reader{folder / "a.mcap"};
  EXPECT_EQ(reader.contents().schemas.size(), 3);
  EXPECT_LT(reader.contents().declared_bytes, std::size_t{64} << 20);
  EXPECT_THAT(reader.damage().sentences, ::testing::Contains(::testing::HasSubstr("declares more than 64 MiB")));

  std::string repeated{magic + record(1, text("ros2") + text(""))};
  for (int i{0}; i < 5; ++i) repeated += chunk_of_schema(1, size);
  put(folder / "b.mcap", repeated + magic);
  EXPECT_THAT(Reader{folder / "b.mcap"}.damage().sentences,
              ::testing::Not(::testing::Contains(::testing::HasSubstr("declares"))));
}

TEST_F(Bag, CopiesOfASchemaAreBounded) {
  std::string bytes{magic + record(1, text("ros2") + text("")) +
                    record(3, number(1, 2) + text("a/msg/B") + text("ros2msg") + text(std::string(1 << 20, 'x')))};
  for (int i{1}; i < 300; ++i) {
    bytes += record(4, number(static_cast<std::uint64_t>(i), 2) + number(1, 2) + text("/t" + std::to_string(i)) +
                           text("cdr") + text(""));
  }
  put(folder / "a.mcap", bytes + record(15, number(0, 4)) + record(2, std::string(20, '\0')) + magic);
  expect_error([&] { return open_bag(folder / "a.mcap"); }, {"a.mcap", "more than 256 MiB of names and schemas"});
}

TEST_F(Bag, RejectsFolders) {
  expect_error([&] { read_all(*open_bag(folder.path())); }, {"holds no recording"});
  const auto expect_rejected = [&](const std::string& metadata, std::string_view part) {
    put(folder / "metadata.yaml", metadata);
    expect_error([&] { read_all(*open_bag(folder.path())); }, {part});
  };
  expect_rejected(
      metadata_begin + "  compression_mode: FILE\n  compression_format: lz4\n  relative_file_paths: [a.db3.lz4]\n",
      "the compression_format is 'lz4' (allowed: zstd)");
  expect_rejected(
      metadata_begin + "  compression_mode: MESSAGE\n  compression_format: lzma\n  relative_file_paths: [a.db3]\n",
      "the compression_format is 'lzma'");
  expect_rejected(metadata_begin + "  relative_file_paths: [missing.db3]\n", "missing.db3: cannot be read");
  expect_rejected(metadata_begin + "  relative_file_paths: [../../etc/passwd]\n",
                  "passwd: cannot be read (No such file");
  expect_rejected(metadata_begin + "  relative_file_paths: []\n", "holds no recording");
  write_db3(folder / "a.db3", {{1, 1, "a"}});
  expect_rejected(metadata_begin + "  relative_file_paths: [a.db3, x/a.db3]\n", "names a.db3 twice");
  expect_rejected("a: [", "is not as rosbag2 writes it");
  expect_rejected("- 1", "metadata.yaml");
}

TEST_F(Bag, DistinguishesFilesByWhatIsInThem) {
  write_messages(folder / "a.bin", {{"/a", 0, 1, 1, "x"}});
  EXPECT_EQ(read_all(*open_bag(folder / "a.bin")).size(), 1);
  put(folder / "a.mcap", zstd("an MCAP file"));
  expect_error([&] { read_all(*open_bag(folder / "a.mcap")); }, {"is not a recording"});
  put(folder / "a.bag", "#ROSBAG V2.0\n");
  expect_error([&] { read_all(*open_bag(folder / "a.bag")); }, {"is a bag of ROS 1", "rosbags-convert"});
  std::filesystem::create_directory(folder / "old");
  std::filesystem::rename(folder / "a.bag", folder / "old" / "a.bag");
  expect_error([&] { read_all(*open_bag(folder / "old")); }, {"a.bag", "is a bag of ROS 1"});
  put(folder / "a.txt", "text");
  expect_error([&] { read_all(*open_bag(folder / "a.txt")); }, {"is not a recording"});
}

TEST_F(Bag, ReadsFilesThatAreCompressedAsAWhole) {
  write_messages(folder / "a.mcap", {{"/a", 0, 1, 1, "first"}});
  write_messages(folder / "b.mcap", {{"/a", 0, 2, 2, "second"}});
  for (const char* const name : {"a.mcap", "b.mcap"}) {
    put(folder / (std::string{name} + ".zstd"), zstd(io::read_text(folder / name, 1'000'000)));
    std::filesystem::remove(folder / name);
  }
  EXPECT_EQ(read_all(*open_bag(folder / "b.mcap.zstd")).size(), 1);
  EXPECT_EQ(read_all(*open_bag(folder.path())).size(), 2) << "without metadata.yaml";
  for (const char* const names : {"[a.mcap.zstd, b.mcap.zstd]", "[a.mcap, b.mcap]"}) {
    put(folder / "metadata.yaml", metadata_begin + "  compression_mode: FILE\n  compression_format: zstd\n" +
                                      "  relative_file_paths: " + names + "\n");
    EXPECT_EQ(read_all(*open_bag(folder.path())).size(), 2) << names;
  }
  const std::string whole{io::read_text(folder / "a.mcap.zstd", 1'000'000)};
  put(folder / "a.mcap.zstd", whole.substr(0, whole.size() - 9));
  expect_error([&] { read_all(*open_bag(folder / "a.mcap.zstd")); }, {"a.mcap.zstd: is a truncated zstd file"});
}

TEST_F(Bag, APackedFileThatGrowsTooMuchIsRejected) {
  const std::string data(1'000'000, 'x');
  write_messages(folder / "a.mcap", {{"/a", 0, 1, 1, data}}, {.compression = Compression::none});
  const std::string recording{io::read_file(folder / "a.mcap")};
  const std::string packed{zstd(recording)};
  ASSERT_GT(recording.size(), most_growth * packed.size());
  put(folder / "a.mcap.zstd", packed);
  EXPECT_EQ(read_all(*open_packed_bag(folder / "a.mcap.zstd", recording.size())),
            (std::vector{ReadMessage{"/a", 1, data}}));
  expect_error([&] { return open_packed_bag(folder / "a.mcap.zstd", recording.size() - 1); },
               {"a.mcap.zstd", "unpacks to more than 200 times its size"});
}

TEST_F(Bag, ReportsDamageInItsParts) {
  write_messages(folder / "a.mcap", random_messages(1, 50));
  const std::string bytes{io::read_file(folder / "a.mcap")};
  put(folder / "a.mcap", bytes.substr(0, bytes.size() - 10));
  const auto bag{open_bag(folder.path())};
  EXPECT_EQ(read_all(*bag).size(), 50);
  EXPECT_THAT(bag->damage(), ElementsAre(::testing::HasSubstr("a.mcap: The summary at byte")));
}

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
