// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/mcap/writer.hpp"

#include <signal.h>
#include <sys/resource.h>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::mcap::testing {
namespace {

/// Bytes behind `data`: the groups of the summary by their opcodes and positions, footer and mark.
std::string end_of(const std::string& data, const std::vector<std::pair<int, std::string>>& groups) {
  const std::string data_end{record(15, number(crc(data), 4))};
  const std::size_t begin{data.size() + data_end.size()};
  std::string summary, offsets;
  for (const auto& [op, group] : groups) {
    offsets += record(
        14, number(static_cast<std::uint64_t>(op), 1) + number(begin + summary.size(), 8) + number(group.size(), 8));
    summary += group;
  }
  const std::string footer{number(2, 1) + number(20, 8) + number(begin, 8) + number(begin + summary.size(), 8)};
  return data_end + summary + offsets + footer + number(crc(summary + offsets + footer), 4) + magic;
}

/// Expected file of one schema, two channels, a metadata record and three messages, built from the specification.
std::string expected_file() {
  const std::string schema{record(3, number(1, 2) + text("pkg/msg/T") + text("ros2msg") + text("int8 x\n"))};
  const std::string channels{
      record(4, number(1, 2) + number(1, 2) + text("/one") + text("cdr") + text(text("k") + text("v"))) +
      record(4, number(2, 2) + number(0, 2) + text("/two") + text("json") + text(""))};
  const std::string metadata{record(12, text("about") + text(text("a") + text("b")))};
  const std::string before{magic + record(1, text("ros2") + text("a test")) + schema + channels + metadata};

  const std::string first{message_record(1, 7, 200, 190, "first")};
  const std::string second{message_record(2, 8, 100, 90, "")};
  const std::string records{first + second + message_record(1, 9, 300, 290, "third")};
  const std::string times{number(100, 8) + number(300, 8)};
  const std::string chunk{record(
      6, times + number(records.size(), 8) + number(crc(records), 4) + text("") + number(records.size(), 8) + records)};
  const std::string index_one{record(7, number(1, 2) + text(number(200, 8) + number(0, 8) + number(300, 8) +
                                                            number(first.size() + second.size(), 8)))};
  const std::string index_two{record(7, number(2, 2) + text(number(100, 8) + number(first.size(), 8)))};
  const std::string data{before + chunk + index_one + index_two};

  const std::size_t index_at{before.size() + chunk.size()};
  const std::string statistics{record(11, number(3, 8) + number(1, 2) + number(2, 4) + number(0, 4) + number(1, 4) +
                                              number(1, 4) + times +
                                              text(number(1, 2) + number(2, 8) + number(2, 2) + number(1, 8)))};
  const std::string chunk_index{
      record(8, times + number(before.size(), 8) + number(chunk.size(), 8) +
                    text(number(1, 2) + number(index_at, 8) + number(2, 2) + number(index_at + index_one.size(), 8)) +
                    number(index_one.size() + index_two.size(), 8) + text("") + number(records.size(), 8) +
                    number(records.size(), 8))};
  const std::string metadata_index{
      record(13, number(before.size() - metadata.size(), 8) + number(metadata.size(), 8) + text("about"))};
  return data + end_of(data, {{3, schema}, {4, channels}, {11, statistics}, {8, chunk_index}, {13, metadata_index}});
}

TEST(Writer, WritesWhatTheSpecificationSaysToTheByte) {
  const TemporaryFolder folder;
  Writer writer{folder / "a.mcap", {.compression = Compression::none, .library = "a test"}};
  const std::uint16_t schema{writer.add_schema("pkg/msg/T", "ros2msg", "int8 x\n")};
  const std::uint16_t one{writer.add_channel("/one", "cdr", schema, {{"k", "v"}})};
  const std::uint16_t two{writer.add_channel("/two", "json", 0, {})};
  writer.write_metadata("about", {{"a", "b"}});
  writer.write(one, 7, 200, 190, bytes_of("first"));
  writer.write(two, 8, 100, 90, {});
  writer.write(one, 9, 300, 290, bytes_of("third"));
  writer.close();
  EXPECT_EQ(io::read_file(folder / "a.mcap"), expected_file());
}

TEST(Writer, AChunkHasNoMoreThanItsBytesAndItsTime) {
  const TemporaryFolder folder;
  const auto chunks = [&](const WriterOptions& options, std::uint64_t step_ns) {
    Writer writer{folder / "a.mcap", options};
    const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
    for (std::uint64_t i{0}; i < 100; ++i) writer.write(channel, 0, i * step_ns, 0, bytes_of("0123456789"));
    writer.close();
    std::size_t found{0};
    const std::string bytes{io::read_file(folder / "a.mcap")};
    for (std::size_t at{8}; at + 9 < bytes.size() && bytes[at] != 15;) {
      found += bytes[at] == 6 ? 1 : 0;
      std::uint64_t length{0};
      for (int i{7}; i >= 0; --i)
        length = length << 8 | static_cast<unsigned char>(bytes[at + 1 + static_cast<std::size_t>(i)]);
      at += 9 + length;
    }
    return found;
  };
  EXPECT_EQ(chunks({.compression = Compression::none, .chunk_bytes = 410}, 1), 10) << "41 bytes each";
  EXPECT_EQ(chunks({.chunk_ns = 1'000'000'000}, 100'000'000), 10) << "ten messages a second";
  EXPECT_EQ(chunks({.chunk_ns = 1'000'000'000}, 0), 1);
  EXPECT_EQ(chunks({.chunk_ns = 0}, 0), 100) << "each message at once";
}

TEST(Writer, FlushBringsWhatThereIsToTheFile) {
  const TemporaryFolder folder;
  Writer writer{folder / "a.mcap"};
  const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
  writer.write(channel, 1, 1, 1, bytes_of("one"));
  EXPECT_TRUE(stream_all(folder / "a.mcap").first.empty());
  writer.flush();
  ASSERT_EQ(stream_all(folder / "a.mcap").first.size(), 1);
  EXPECT_EQ(stream_all(folder / "a.mcap").first[0].data, "one");
}

TEST(Writer, RejectsInvalidValues) {
  const TemporaryFolder folder;
  Writer writer{folder / "a.mcap"};
  EXPECT_THROW(writer.write(1, 0, 0, 0, {}), std::invalid_argument);
  EXPECT_THROW(writer.add_channel("/x", "cdr", 1, {}), std::invalid_argument);
  writer.close();
  writer.close();
  EXPECT_THROW(writer.flush(), std::logic_error);
  EXPECT_THROW(writer.add_schema("a", "b", "c"), std::logic_error);
  EXPECT_THROW((Writer{folder / "b.mcap", {.chunk_bytes = std::size_t{1} << 30}}), std::invalid_argument);
  expect_error<DeviceError>([&] { Writer{folder / "no" / "such.mcap"}; }, {"such.mcap: cannot be written"});
  expect_error<DeviceError>([&] { Writer{folder.path()}; }, {"cannot be written"});
}

TEST(Writer, ADestroyedWriterHasClosedItsFile) {
  const TemporaryFolder folder;
  {
    Writer writer{folder / "a.mcap"};
    writer.write(writer.add_channel("/x", "cdr", 0, {}), 1, 1, 1, bytes_of("one"));
    const Writer moved{std::move(writer)};
  }
  EXPECT_TRUE(Reader{folder / "a.mcap"}.is_indexed());
}

/// Files cannot grow beyond a size while it lives.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(Writer, AFullDiskLeavesEveryWholeChunk) {
  const TemporaryFolder folder;
  const std::string data(1000, 'x');
  Writer writer{folder / "a.mcap", {.compression = Compression::none, .chunk_bytes = 10'000}};
  const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
  std::uint32_t written{0};
  {
    const FullDisk full{64'000};
    const auto write_many = [&] {
      for (; written < 100; ++written) writer.write(channel, written, written, written, bytes_of(data));
    };
    expect_error<DeviceError>(write_many, {"a.mcap: cannot be written (File too large).", "Free some space"});
    EXPECT_THROW(writer.close(), DeviceError);
  }
  EXPECT_THROW(writer.write(channel, 0, 0, 0, {}), DeviceError) << "and stays so, for the file has an end";
  const auto [messages, damage]{stream_all(folder / "a.mcap")};
  EXPECT_EQ(messages.size(), 60) << "six whole chunks of 10 fit into 64 000 bytes";
  ASSERT_EQ(damage.sentences.size(), 1);
  EXPECT_THAT(damage.sentences[0], ::testing::HasSubstr("cut off there"));
  EXPECT_THAT(damage.sentences[0], ::testing::HasSubstr("60 messages were read; whatever the last 0 bytes"));
}

TEST(Writer, WritesQosAsRosbag2Does) {
  EXPECT_EQ(offered_qos_profiles({.depth = 1, .reliable = true, .transient_local = true}),
            "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    nsec: "
            "854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  "
            "liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: "
            "false");
  EXPECT_THAT(offered_qos_profiles({.depth = 5, .reliable = false}),
              ::testing::AllOf(::testing::HasSubstr("reliability: 2"), ::testing::HasSubstr("durability: 2")));
}

}  // namespace
}  // namespace stereogrid::mcap::testing
