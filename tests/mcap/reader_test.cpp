// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/mcap/reader.hpp"

#include "../core/allocations.hpp"
#include "support.hpp"

namespace stereogrid::mcap::testing {
namespace {

TEST(Reader, GivesWhatWasWrittenInTimeWhateverTheCompressionAndChunks) {
  const TemporaryFolder folder;
  const fs::path path{folder / "a.mcap"};
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    for (const std::size_t chunk_bytes :
         {std::size_t{0}, std::size_t{500}, std::size_t{20'000}, std::size_t{1} << 20}) {
      const auto written{random_messages(static_cast<unsigned>(chunk_bytes), 700)};
      write_messages(path, written, {compression, chunk_bytes});
      const Reader reader{path};
      EXPECT_TRUE(reader.is_indexed());
      EXPECT_EQ(read_all(reader), in_time(written));
      EXPECT_FALSE(reader.damage().any());
      const auto [streamed, damage]{stream_all(path)};
      EXPECT_EQ(streamed, written) << "a stream is in the order of the file";
      EXPECT_FALSE(damage.any()) << damage.sentences[0];
    }
  }
}

TEST(Reader, ReportsWhatAFileHolds) {
  const TemporaryFolder folder;
  const auto written{random_messages(3, 200)};
  write_messages(folder / "a.mcap", written);
  const Reader reader{folder / "a.mcap"};
  const Contents& contents{reader.contents()};
  EXPECT_EQ(contents.profile, "ros2");
  EXPECT_EQ(contents.library, "stereogrid");
  EXPECT_EQ(contents.schemas.at(1), (Schema{"std_msgs/msg/String", "ros2msg", "string data\n"}));
  EXPECT_EQ(contents.channels.at(3), (Channel{2, "/c", "cdr", {{"offered_qos_profiles", offered_qos_profiles({})}}}));
  EXPECT_EQ(contents.first_ns, in_time(written).front().log_ns);
  EXPECT_EQ(contents.last_ns, in_time(written).back().log_ns);
  EXPECT_EQ(contents.message_counts.at(2), std::ranges::count(written, std::string{"/b"}, &Said::topic));

  StreamReader stream{folder / "a.mcap"};
  while (stream.next() != nullptr) continue;
  EXPECT_EQ(stream.next(), nullptr) << "the end stays the end";
  EXPECT_EQ(stream.contents().schemas, contents.schemas);
  EXPECT_EQ(stream.contents().channels, contents.channels);
  EXPECT_EQ(stream.contents().message_counts, contents.message_counts);
  EXPECT_EQ(stream.contents().first_ns, contents.first_ns);
  EXPECT_EQ(stream.contents().last_ns, contents.last_ns);
  EXPECT_EQ(stream.contents().library, contents.library);
}

TEST(Reader, GivesTopicsAndTimesThatAreAskedFor) {
  const TemporaryFolder folder;
  const auto written{random_messages(4, 500)};
  write_messages(folder / "a.mcap", written, {.chunk_bytes = 1000});
  const Reader reader{folder / "a.mcap"};
  const Selection selection{{"/a", "/c", "/unknown"}, written[200].log_ns, written[300].log_ns};
  auto expected{in_time(written)};
  std::erase_if(expected, [&](const Said& said) {
    return said.topic == "/b" || said.log_ns < selection.first_ns || said.log_ns > selection.last_ns;
  });
  ASSERT_GT(expected.size(), 50);
  EXPECT_EQ(read_all(reader, selection), expected);
  EXPECT_TRUE(read_all(reader, {.topics = {"/unknown"}}).empty());
  EXPECT_TRUE(read_all(reader, {.first_ns = 9'000'000'000'000}).empty());
}

TEST(Reader, SeveralCursorsAndNoReaderAnyMore) {
  const TemporaryFolder folder;
  const auto written{random_messages(5, 300)};
  write_messages(folder / "a.mcap", written, {.chunk_bytes = 2000});
  std::unique_ptr<MessageCursor> one, two;
  {
    const Reader reader{folder / "a.mcap"};
    one = reader.messages();
    two = reader.messages({.topics = {"/a"}});
  }
  const auto expected{in_time(written)};
  for (const Said& said : expected) {
    const Message* const message{one->next()};
    ASSERT_NE(message, nullptr);
    EXPECT_EQ(string_of(message->data), said.data);
    if (said.topic != "/a") continue;
    EXPECT_EQ(two->next()->sequence, said.sequence);
  }
  EXPECT_EQ(one->next(), nullptr);
  EXPECT_EQ(two->next(), nullptr);
}

TEST(Reader, MessagesOfEqualTimeStandAsInTheFile) {
  const TemporaryFolder folder;
  std::vector<Said> written;
  for (std::uint32_t i{0}; i < 50; ++i) written.push_back({i % 2 == 0 ? "/a" : "/b", i, 5 + i / 20, 0, "x"});
  write_messages(folder / "a.mcap", written, {.chunk_bytes = 100});
  EXPECT_EQ(read_all(Reader{folder / "a.mcap"}), written);
}

TEST(Reader, AFileWithoutMessagesIsFine) {
  const TemporaryFolder folder;
  write_messages(folder / "a.mcap", {});
  const Reader reader{folder / "a.mcap"};
  EXPECT_TRUE(reader.is_indexed());
  EXPECT_TRUE(read_all(reader).empty());
  EXPECT_EQ(reader.contents().channels.size(), 3);
  EXPECT_FALSE(stream_all(folder / "a.mcap").second.any());
}

const std::string schema{record(3, number(4, 2) + text("pkg/msg/T") + text("ros2msg") + text("int8 x\n"))};
const std::string channel{record(4, number(0, 2) + number(4, 2) + text("/x") + text("cdr") + text(""))};

/// As others write it: without chunks, with what we never write, and with the least that the specification allows.
std::string plain_file(int messages) {
  std::string file{magic + record(1, text("") + text("by hand") + "a field of a later version") + schema + channel};
  for (int i{0}; i < messages; ++i) {
    const auto time{static_cast<std::uint64_t>(messages - i)};
    file += message_record(0, i, time, time, "data");
    if (i % 7 == 3) {  // an attachment, an unknown record, one of an application
      file += record(
          9, number(1, 8) + number(1, 8) + text("a.jpg") + text("image/jpeg") + number(3, 8) + "abc" + number(0, 4));
      file += record(0x42, "later") + record(0x99, "");
    }
  }
  return file + record(15, number(0, 4)) + record(2, number(0, 8) + number(0, 8) + number(0, 4)) + magic;
}

TEST(Reader, ReadsFilesWithoutChunksAndSummary) {
  const TemporaryFolder folder;
  put(folder / "a.mcap", plain_file(100));
  const Reader reader{folder / "a.mcap"};
  EXPECT_FALSE(reader.is_indexed());
  EXPECT_FALSE(reader.damage().any()) << reader.damage().sentences[0];
  const auto read{read_all(reader)};
  ASSERT_EQ(read.size(), 100);
  for (std::uint32_t i{0}; i < 100; ++i) EXPECT_EQ(read[i], (Said{"/x", 99 - i, i + 1, i + 1, "data"}));
  EXPECT_EQ(stream_all(folder / "a.mcap").first.size(), 100);
  EXPECT_EQ(reader.contents().message_counts.at(0), 100);
  EXPECT_EQ(reader.contents().library, "by hand");
  EXPECT_EQ(read_all(reader, {.topics = {"/x"}, .first_ns = 10, .last_ns = 19}).size(), 10);
}

TEST(Reader, ReadsTheSmallestFile) {
  const TemporaryFolder folder;
  put(folder / "a.mcap",
      magic + record(1, text("") + text("")) + record(2, number(0, 8) + number(0, 8) + number(0, 4)) + magic);
  const Reader reader{folder / "a.mcap"};
  EXPECT_TRUE(read_all(reader).empty());
  EXPECT_FALSE(reader.damage().any()) << reader.damage().sentences[0];
}

/// A chunk that declares its channel itself, without checksum, as rosbag2's writer makes it.
TEST(Reader, ReadsDeclarationsWithinChunks) {
  const TemporaryFolder folder;
  const std::string records{schema + channel + message_record(0, 1, 5, 5, "data")};
  const std::string chunk{record(6, number(5, 8) + number(5, 8) + number(records.size(), 8) + number(0, 4) + text("") +
                                        number(records.size(), 8) + records)};
  put(folder / "a.mcap", magic + record(1, text("ros2") + text("")) + chunk + record(15, number(0, 4)) +
                             record(2, number(0, 8) + number(0, 8) + number(0, 4)) + magic);
  const Reader reader{folder / "a.mcap"};
  EXPECT_EQ(read_all(reader), (std::vector<Said>{{"/x", 1, 5, 5, "data"}}));
  EXPECT_EQ(reader.contents().schemas.at(4).name, "pkg/msg/T");
  EXPECT_FALSE(reader.damage().any());
}

TEST(Reader, NamesWhatIsNoMcapFile) {
  const TemporaryFolder folder;
  expect_error([&] { Reader{folder / "missing.mcap"}; }, {"missing.mcap: cannot be read (No such file"});
  expect_error([&] { StreamReader{folder.path()}; }, {"is not a file on a disk"});
  put(folder / "empty.mcap", "");
  expect_error([&] { Reader{folder / "empty.mcap"}; }, {"fewer than 8 bytes"});
  put(folder / "text.mcap", "some text or other");
  expect_error([&] { StreamReader{folder / "text.mcap"}; }, {"is not an MCAP file", "at byte 0"});
}

constexpr std::size_t chunk_bytes{std::size_t{1} << 16};
constexpr std::uint32_t messages{20'000};

/// 20 MB in 300 chunks.
void write_long_file(const fs::path& path, Compression compression) {
  Writer writer{path, {.compression = compression, .chunk_bytes = chunk_bytes, .chunk_ns = ~std::uint64_t{0}}};
  const std::uint16_t id{writer.add_channel("/x", "cdr", 0, {})};
  std::string data(1000, 'x');
  for (std::uint32_t i{0}; i < messages; ++i) {
    data[i % data.size()] = static_cast<char>(i);
    writer.write(id, i, i, i, bytes_of(data));
  }
  writer.close();
}

TEST(Memory, ReadingHoldsAChunkOrTwo) {
  if (!test::can_count_allocations()) GTEST_SKIP() << "allocations cannot be counted here";
  const TemporaryFolder folder;
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    write_long_file(folder / "a.mcap", compression);
    const std::ptrdiff_t before{test::live_bytes()};
    std::ptrdiff_t most{0};
    const auto drain = [&](MessageCursor& cursor) {
      std::uint32_t count{0};
      for (; cursor.next() != nullptr; ++count) most = std::max(most, test::live_bytes() - before);
      EXPECT_EQ(count, messages);
    };
    const Reader reader{folder / "a.mcap"};
    drain(*reader.messages());
    StreamReader stream{folder / "a.mcap"};
    drain(stream);
    EXPECT_LT(most, 8 * std::ptrdiff_t{chunk_bytes}) << "of 20 MB";
  }
}

TEST(Memory, WritingAllocatesNothingPerMessage) {
  if (!test::can_count_allocations()) GTEST_SKIP() << "allocations cannot be counted here";
  const TemporaryFolder folder;
  Writer writer{folder / "a.mcap", {.compression = Compression::none, .chunk_bytes = chunk_bytes}};
  const std::uint16_t id{writer.add_channel("/x", "cdr", 0, {})};
  const std::string data(1000, 'x');
  const auto write_chunk = [&] {
    for (std::uint32_t i{0}; i < 60; ++i) writer.write(id, i, i, i, bytes_of(data));
  };
  for (int chunk{0}; chunk < 3; ++chunk) {
    write_chunk();
    writer.flush();
  }
  test::start_counting();
  write_chunk();
  EXPECT_EQ(test::stop_counting().count, 0);
  const std::ptrdiff_t before{test::live_bytes()};
  for (int chunk{0}; chunk < 500; ++chunk) {
    write_chunk();
    writer.flush();
  }
  EXPECT_LT(test::live_bytes() - before, 500 * 300) << "30 MB later: the places of 500 chunks, and room for more";
}

TEST(Memory, AChunkThatClaimsHalfAGigabyteGetsWhatItHas) {
  if (!test::can_count_allocations()) GTEST_SKIP() << "allocations cannot be counted here";
  const TemporaryFolder folder;
  const std::string empty_frame{"\x28\xb5\x2f\xfd\x00\x00\x01\x00\x00", 9};
  put(folder / "a.mcap", magic + record(1, text("") + text("")) +
                             record(6, number(0, 8) + number(9, 8) + number(std::uint64_t{1} << 29, 8) + number(0, 4) +
                                           text("zstd") + number(empty_frame.size(), 8) + empty_frame));
  test::start_counting();
  EXPECT_EQ(stream_all(folder / "a.mcap").second.chunks_skipped, 1);
  EXPECT_LT(test::stop_counting().bytes, 2'000'000);
}

}  // namespace
}  // namespace stereogrid::mcap::testing
