// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::mcap::testing {
namespace {

using Damage = FolderTest;

using ::testing::HasSubstr;

/// A small file of several chunks, and where its chunks end: how many messages are whole up to there.
struct Small {
  std::string bytes;
  std::vector<Said> written;
  std::vector<std::pair<std::size_t, std::size_t>> whole;  // bytes, messages
};

Small small_file(const TemporaryFolder& folder, Compression compression) {
  Small small;
  const fs::path path{folder / "small.mcap"};
  Writer writer{path, {.compression = compression}};
  const std::uint16_t channel{writer.add_channel("/a", "cdr", writer.add_schema("p/msg/T", "ros2msg", "x"), {})};
  for (std::uint32_t i{0}; i < 9; ++i) {
    small.written.push_back({"/a", i, 10 * i, 10 * i, std::string(i, 'd')});
    writer.write(channel, i, 10 * i, 10 * i, bytes_of(small.written.back().data));
    if (i % 3 != 2) continue;
    const std::size_t before{fs::file_size(path)};
    writer.flush();
    // the message index behind a chunk is no part of it
    const std::size_t index_bytes{9 + 2 + 4 + 3 * 16};
    small.whole.emplace_back(fs::file_size(path) - index_bytes, i + 1);
    EXPECT_GT(small.whole.back().first, before);
  }
  writer.close();
  small.bytes = io::read_file(path);
  return small;
}

std::size_t messages_in(const Small& small, std::size_t bytes) {
  std::size_t messages{0};
  for (const auto& [end, count] : small.whole) messages = bytes >= end ? count : messages;
  return messages;
}

TEST_F(Damage, CutOffAtAnyByteAFileGivesEveryMessageOfEveryWholeChunk) {
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    const Small small{small_file(folder, compression)};
    for (std::size_t bytes{magic.size()}; bytes < small.bytes.size(); ++bytes) {
      put(folder / "cut.mcap", small.bytes.substr(0, bytes));
      const std::vector<Said> whole(small.written.begin(),
                                    small.written.begin() + static_cast<std::ptrdiff_t>(messages_in(small, bytes)));
      const auto [streamed, damage]{stream_all(folder / "cut.mcap")};
      EXPECT_EQ(streamed, whole) << bytes;
      EXPECT_TRUE(damage.any()) << bytes;
      const Reader reader{folder / "cut.mcap"};
      EXPECT_EQ(read_all(reader), whole) << bytes;
      EXPECT_TRUE(reader.damage().any()) << bytes;
    }
  }
}

TEST_F(Damage, SaysHowFarItGotAndWhatIsLost) {
  const Small small{small_file(folder, Compression::none)};
  put(folder / "cut.mcap", small.bytes.substr(0, small.whole[2].first - 1));
  const auto damage{stream_all(folder / "cut.mcap").second};
  ASSERT_EQ(damage.sentences.size(), 1);
  EXPECT_THAT(damage.sentences[0], HasSubstr("The file can be read up to byte "));
  EXPECT_THAT(damage.sentences[0], HasSubstr("in the middle of a record"));
  EXPECT_THAT(damage.sentences[0], HasSubstr("6 messages were read"));
}

/// Every message that comes must be one that was written, as checksums cover them all.
TEST_F(Damage, AnyFlippedBitIsReportedAndGivesNoWrongMessage) {
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd}) {
    const Small small{small_file(folder, compression)};
    for (std::size_t bit{0}; bit < small.bytes.size() * 8; ++bit) {
      std::string flipped{small.bytes};
      flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
      put(folder / "flipped.mcap", flipped);
      try {
        const auto [streamed, damage]{stream_all(folder / "flipped.mcap")};
        EXPECT_TRUE(damage.any()) << bit;
        for (Said said : streamed) {
          said.topic = "/a";  // the flipped byte may be in the topic
          EXPECT_EQ(std::ranges::count(small.written, said), 1) << bit << ": " << said;
        }
        EXPECT_GE(read_all(Reader{folder / "flipped.mcap"}).size(), streamed.size()) << bit;
      } catch (const InputError& error) {
        EXPECT_LT(bit, 64) << "only without its mark it is not an MCAP file: " << error.what();
      }
    }
  }
}

TEST_F(Damage, ADamagedChunkInTheMiddleIsSkippedAndCounted) {
  Small small{small_file(folder, Compression::none)};
  small.bytes[small.whole[1].first - 1] ^= 1;  // the last byte of the second chunk's data
  put(folder / "a.mcap", small.bytes);
  std::vector<Said> expected{small.written};
  expected.erase(expected.begin() + 3, expected.begin() + 6);

  const auto [streamed, damage]{stream_all(folder / "a.mcap")};
  EXPECT_EQ(streamed, expected);
  EXPECT_EQ(damage.chunks_skipped, 1);
  ASSERT_EQ(damage.sentences.size(), 2) << "the data section has a checksum, too";
  EXPECT_THAT(damage.sentences[0], HasSubstr("is skipped: its checksum is wrong"));

  const Reader reader{folder / "a.mcap"};
  EXPECT_TRUE(reader.is_indexed());
  EXPECT_EQ(read_all(reader), expected);
  EXPECT_EQ(read_all(reader), expected) << "again";
  EXPECT_EQ(reader.damage().chunks_skipped, 1) << "counted once";
  EXPECT_THAT(reader.damage().sentences.at(0), HasSubstr("is skipped: its checksum is wrong"));
}

/// The index finds messages behind a place at which a stream must stop.
TEST_F(Damage, TheIndexLeadsOverDamageThatStopsAStream) {
  Small small{small_file(folder, Compression::zstd)};
  small.bytes[small.whole[0].first + 5] = '\x7f';  // the length of the first message index
  put(folder / "a.mcap", small.bytes);
  const auto [streamed, damage]{stream_all(folder / "a.mcap")};
  EXPECT_EQ(streamed.size(), 3);
  EXPECT_THAT(damage.sentences.at(0), HasSubstr("wrong length"));
  EXPECT_EQ(read_all(Reader{folder / "a.mcap"}), small.written);
}

std::string chunk_that_says(std::uint64_t size, std::string_view compression, std::string_view packed) {
  return record(6, number(0, 8) + number(9, 8) + number(size, 8) + number(0, 4) + text(compression) +
                       number(packed.size(), 8) + std::string{packed});
}

TEST_F(Damage, SizesThatCannotBeAreRejected) {
  const std::string begin{magic + record(1, text("") + text(""))};
  const std::string channel{record(4, number(1, 2) + number(0, 2) + text("/x") + text("cdr") + text(""))};
  const std::string zeros{"\x28\xb5\x2f\xfd\x00\x00\x01\x00\x00", 9};  // zstd: an empty raw block, which is the last
  const std::vector<std::pair<std::string, std::string>> cases{
      {chunk_that_says(std::uint64_t{1} << 62, "", ""), "has more than 512 MiB"},
      {chunk_that_says(std::uint64_t{1} << 29, "zstd", zeros), "has another size than it says"},
      {chunk_that_says(10, "zstd", "no zstd"), "is not zstd"},
      {chunk_that_says(10, "lz4", "no lz4 at all"), "is not lz4"},
      {chunk_that_says(10, "brotli", "0123456789"), "in another way than by lz4 or zstd"},
      {chunk_that_says(9, "", "0123456789"), "has another size than it says"},
      {chunk_that_says(10, "", "0123456789"), "a record in it is longer than it"},
      {chunk_that_says(5, "", "01234"), "its last record is cut off"},
      {chunk_that_says(13, "", record(5, "abcd")), "a message in it is cut off"},
      {record(6, "short"), "a field is longer than its record"},
      {record(5, "short"), "a message in it is cut off"},
      {record(4, number(1, 2) + number(0, 2) + number(0xffffffff, 4)), "a declaration is skipped"},
      {message_record(2, 0, 0, 0, ""), "declared nowhere"},
      {"\x06" + number(~std::uint64_t{0}, 8), "wrong length"},
      {std::string(9, '\0'), "not a record"},
      {record(8, ""), "behind the end of all messages"}};
  for (const auto& [bytes, sentence] : cases) {
    put(folder / "a.mcap", begin + channel + bytes + message_record(1, 1, 1, 1, "after"));
    const auto damage{stream_all(folder / "a.mcap").second};
    EXPECT_THAT(damage.sentences, ::testing::Contains(HasSubstr(sentence)));
    const Reader reader{folder / "a.mcap"};
    EXPECT_LE(read_all(reader).size(), 1);
    EXPECT_THAT(reader.damage().sentences, ::testing::Contains(HasSubstr(sentence)));
  }
}

TEST_F(Damage, ASummaryThatLiesIsRejected) {
  const auto with_chunk_at = [&](std::uint64_t offset, std::uint64_t length) {
    const std::string data{magic + record(1, text("") + text("")) +
                           record(4, number(1, 2) + number(0, 2) + text("/x") + text("cdr") + text("")) +
                           message_record(1, 1, 1, 1, "data") + record(15, number(0, 4))};
    const std::string summary{record(11, number(1, 8) + number(0, 2) + number(1, 4) + number(0, 4) + number(0, 4) +
                                             number(1, 4) + number(1, 8) + number(1, 8) +
                                             text(number(1, 2) + number(1, 8))) +
                              record(4, number(1, 2) + number(0, 2) + text("/x") + text("cdr") + text("")) +
                              record(8, number(1, 8) + number(1, 8) + number(offset, 8) + number(length, 8) + text("") +
                                            number(0, 8) + text("") + number(0, 8) + number(0, 8))};
    put(folder / "a.mcap", data + summary + record(2, number(data.size(), 8) + number(0, 8) + number(0, 4)) + magic);
    return data.size();
  };
  for (const auto& [offset, length] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
           {0, 100}, {~std::uint64_t{0}, 9}, {30, ~std::uint64_t{0}}, {1'000'000, 10}}) {
    with_chunk_at(offset, length);
    const Reader reader{folder / "a.mcap"};
    EXPECT_FALSE(reader.is_indexed());
    EXPECT_EQ(read_all(reader).size(), 1) << "found by going through the file";
  }
  with_chunk_at(30, 10);  // within the file, but no chunk
  const Reader reader{folder / "a.mcap"};
  EXPECT_TRUE(reader.is_indexed());
  EXPECT_TRUE(read_all(reader).empty());
  EXPECT_THAT(reader.damage().sentences.at(0), HasSubstr("there is no chunk"));
}

TEST_F(Damage, AChunkWhoseTimesAreOtherThanTheIndexSaysIsSkipped) {
  std::string records;
  for (const std::uint64_t time : {5, 6}) records += message_record(1, 1, time, time, "");
  const std::string chunk{chunk_that_says(records.size(), "", records)};
  const std::string begin{magic + record(1, text("") + text(""))};
  const std::string channel{record(4, number(1, 2) + number(0, 2) + text("/x") + text("cdr") + text(""))};
  const std::string data{begin + chunk + record(15, number(0, 4))};
  const auto read_with_index_of = [&](std::uint64_t first_ns) {
    const std::string summary{
        channel +
        record(11, number(2, 8) + number(0, 2) + number(1, 4) + number(0, 8) + number(1, 4) + number(first_ns, 8) +
                       number(9, 8) + text(number(1, 2) + number(2, 8))) +
        record(8, number(first_ns, 8) + number(9, 8) + number(begin.size(), 8) + number(chunk.size(), 8) + text(""))};
    put(folder / "a.mcap", data + summary + record(2, number(data.size(), 8) + number(0, 8) + number(0, 4)) + magic);
    const Reader reader{folder / "a.mcap"};
    EXPECT_TRUE(reader.is_indexed());
    return std::pair{read_all(reader).size(), reader.damage().chunks_skipped};
  };
  EXPECT_EQ(read_with_index_of(5), (std::pair{std::size_t{2}, std::uint64_t{0}}));
  EXPECT_EQ(read_with_index_of(6), (std::pair{std::size_t{0}, std::uint64_t{1}}));
}

TEST_F(Damage, AProcessThatIsKilledLeavesAReadableFile) {
  const fs::path path{folder / "killed.mcap"};
  for (int attempt{0}; attempt < 5; ++attempt) {
    const pid_t child{::fork()};
    if (child == 0) {
      Writer writer{path, {.chunk_bytes = 20'000}};
      const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
      for (std::uint32_t i{0};; ++i) {
        const std::string data(100 + i % 1000, static_cast<char>(i));
        writer.write(channel, i, i, i, bytes_of(data));
      }
    }
    while (!fs::exists(path) || fs::file_size(path) < 100'000)
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const Reader reader{path};
    const auto messages{read_all(reader)};
    EXPECT_GT(messages.size(), 50);
    for (std::uint32_t i{0}; i < messages.size(); ++i) {
      ASSERT_EQ(messages[i].sequence, i);
      ASSERT_EQ(messages[i].data, std::string(100 + i % 1000, static_cast<char>(i)));
    }
    EXPECT_THAT(reader.damage().sentences.at(0), HasSubstr("cut off"));
    fs::remove(path);
  }
}

}  // namespace
}  // namespace stereogrid::mcap::testing
