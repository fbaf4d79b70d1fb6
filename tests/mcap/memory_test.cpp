// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "../core/allocations.hpp"
#include "support.hpp"

namespace stereogrid::mcap::testing {
namespace {

constexpr std::size_t chunk_bytes{std::size_t{1} << 16};
constexpr std::uint32_t messages{20'000};

/// 20 MB in 300 chunks.
void write_long_file(const fs::path& path, Compression compression) {
  Writer writer{path, {.compression = compression, .chunk_bytes = chunk_bytes, .chunk_ns = ~std::uint64_t{0}}};
  const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
  std::string data(1000, 'x');
  for (std::uint32_t i{0}; i < messages; ++i) {
    data[i % data.size()] = static_cast<char>(i);
    writer.write(channel, i, i, i, bytes_of(data));
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
  const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
  const std::string data(1000, 'x');
  const auto write_chunk = [&] {
    for (std::uint32_t i{0}; i < 60; ++i) writer.write(channel, i, i, i, bytes_of(data));
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
