// SPDX-License-Identifier: Apache-2.0
//
// Allocations of sending: none after the first frames but for points. Allocations of a decoder with malicious bytes.
#include <gtest/gtest.h>

#include <cstring>

#include "../core/allocations.hpp"
#include "random_filler.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::messages::test {
namespace {

using stereogrid::test::Allocations;
using stereogrid::test::can_count_allocations;
using stereogrid::test::start_counting;
using stereogrid::test::stop_counting;

class Counter : public Sink {
 public:
  std::uint32_t add(const Channel& /*channel*/) override { return channels++; }
  [[nodiscard]] bool wants(std::uint32_t /*channel*/) const override { return true; }
  void send(std::uint32_t /*channel*/, std::int64_t /*stamp_ns*/, std::span<const std::byte> cdr) override {
    bytes += cdr.size();
  }

  std::uint32_t channels{0};
  std::size_t bytes{0};
};

TEST(MessageAllocation, IsNoneButOfThePointsOnceItRuns) {
  if (!can_count_allocations()) GTEST_SKIP() << "malloc cannot be counted under a sanitizer, nor without glibc";
  const scenes::Scene scene{scenes::parse_scene("street?width=320&height=160&frames=15"), 2};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .horizons_s = {0.5}}};
  Counter counter;
  FrameMessages messages{counter, pipeline.rig()};
  const std::vector<std::byte> bytes(10'000);
  const auto jpeg = [&bytes](int) { return std::span{bytes}; };
  FrameResult result;
  for (std::size_t i{0}; i < scene.size(); ++i) pipeline.process(scene.load(i), result);
  ASSERT_GT(result.obstacles.size(), 2u);
  messages.send(result, {.stamp_ns = 1, .left_jpeg = jpeg, .u_disparity_jpeg = jpeg});
  EXPECT_GT(counter.bytes, 500'000u);
  start_counting();
  messages.send(result, {.stamp_ns = 2'000'000'000, .left_jpeg = jpeg, .u_disparity_jpeg = jpeg});
  const Allocations found{stop_counting()};
  EXPECT_EQ(found.count, 1) << found.bytes << " bytes by " << testing::PrintToString(found.where);
}

template <Message M>
std::size_t bytes_to_decode(const std::vector<std::byte>& cdr) {
  start_counting();
  {
    M message;
    try {
      decode(cdr, message);
    } catch (const InputError&) {
    }
  }
  return stop_counting().bytes;
}

// Any four bytes become a huge count, one after the other. 80 bytes of a marker's fields are over 500 in memory.
TEST(MessageAllocation, OfHostileBytesStaysSmall) {
  if (!can_count_allocations()) GTEST_SKIP() << "malloc cannot be counted under a sanitizer, nor without glibc";
  for_each_type([]<Message M>(const M& /*type*/) {
    M message;
    RandomFiller{7}.fill(message);
    CdrWriter writer;
    const auto encoded{writer.encode(message)};
    for (std::size_t at{4}; at + 4 <= encoded.size(); at += 4) {
      for (const std::uint32_t count : {0xffffffffu, 0x7fffffffu, 0x00ffffffu, 0x40u}) {
        std::vector<std::byte> cdr{encoded.begin(), encoded.end()};
        std::memcpy(cdr.data() + at, &count, sizeof(count));
        EXPECT_LT(bytes_to_decode<M>(cdr), 12 * cdr.size() + 4'000) << M::type_name << " at " << at;
      }
    }
  });
}

}  // namespace
}  // namespace stereogrid::messages::test
