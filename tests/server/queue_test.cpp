// SPDX-License-Identifier: Apache-2.0
#include "foxglove/message_queue.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "stereogrid/error.hpp"
#include "stereogrid/server/metrics.hpp"

namespace stereogrid::server::testing {
namespace {

using ::testing::ElementsAre, ::testing::IsEmpty;

SharedMessage message(ChannelId channel, std::uint64_t stamp_ns, std::size_t size = 1) {
  return std::make_shared<const Message>(Message{channel, stamp_ns, std::vector<std::byte>(size)});
}

std::vector<std::uint64_t> drained(MessageQueue& queue) {
  std::vector<std::uint64_t> stamps;
  while (const SharedMessage one{queue.pop()}) stamps.push_back(one->stamp_ns);
  return stamps;
}

constexpr std::size_t plenty{1 << 20};
constexpr std::size_t overhead{sizeof(Message)};

TEST(Queue, KeepsTheOrder) {
  MessageQueue queue{{plenty, 10}};
  for (const ChannelId channel : {1U, 2U, 1U, 3U}) EXPECT_EQ(queue.push(message(channel, channel)), 0U);
  EXPECT_THAT(drained(queue), ElementsAre(1, 2, 1, 3));
  EXPECT_EQ(queue.bytes(), 0U);
  EXPECT_EQ(queue.pop(), nullptr);
}

TEST(Queue, AChannelLosesItsOwnOldest) {
  MessageQueue queue{{plenty, 2}};
  queue.push(message(9, 100));
  for (const std::uint64_t stamp : {1U, 2U, 3U, 4U}) queue.push(message(1, stamp));
  EXPECT_THAT(drained(queue), ElementsAre(100, 3, 4));
}

TEST(Queue, BytesAreBounded) {
  MessageQueue queue{{3 * (1000 + overhead), 100}};
  std::size_t dropped{0};
  for (std::uint64_t stamp{0}; stamp < 10; ++stamp) {
    dropped += queue.push(message(1, stamp, 1000));
    EXPECT_LE(queue.bytes(), 3 * (1000 + overhead));
  }
  EXPECT_EQ(dropped, 7U);
  EXPECT_THAT(drained(queue), ElementsAre(7, 8, 9));
}

TEST(Queue, ASmallChannelMakesRoomAtTheLargestOnesExpense) {
  MessageQueue queue{{2 * (1000 + overhead), 100}};
  queue.push(message(2, 50, 10));
  queue.push(message(1, 1, 900));
  queue.push(message(1, 2, 900));
  EXPECT_EQ(queue.push(message(3, 60, 200)), 1U);
  EXPECT_THAT(drained(queue), ElementsAre(50, 2, 60));
}

TEST(Queue, ASingleMessageMayBeLarger) {
  MessageQueue queue{{100, 10}};
  queue.push(message(1, 1, 10));
  queue.push(message(2, 2, 5000));
  EXPECT_THAT(drained(queue), ElementsAre(2));
}

TEST(Queue, AChannelIsRemoved) {
  MessageQueue queue{{plenty, 10}};
  for (const std::uint64_t stamp : {1U, 2U, 3U}) queue.push(message(static_cast<ChannelId>(stamp % 2), stamp, 50));
  queue.remove(1);
  queue.remove(7);
  EXPECT_EQ(queue.bytes(), 50 + overhead);
  EXPECT_THAT(drained(queue), ElementsAre(2));
}

TEST(InboxTest, IsBoundedHoweverLongNobodyFetches) {
  Counters counters;
  Inbox inbox{{plenty, 4}, counters};
  inbox.open(1, true);
  EXPECT_TRUE(inbox.put(message(1, 0)));
  for (std::uint64_t stamp{1}; stamp < 100; ++stamp) EXPECT_FALSE(inbox.put(message(1, stamp))) << "changed already";
  EXPECT_EQ(counters.messages_dropped, 96U);
  std::vector<std::uint64_t> stamps;
  while (const SharedMessage one{inbox.take()}) stamps.push_back(one->stamp_ns);
  EXPECT_THAT(stamps, ElementsAre(96, 97, 98, 99));
  EXPECT_TRUE(inbox.put(message(1, 100))) << "to be changed again";
}

TEST(InboxTest, AClosedChannelIsWantedByNobody) {
  Counters counters;
  Inbox inbox{{plenty, 4}, counters};
  inbox.open(1, false);
  EXPECT_FALSE(inbox.wanted(1));
  inbox.set_subscribers(1, 2);
  EXPECT_TRUE(inbox.wanted(1));
  EXPECT_TRUE(inbox.put(message(1, 1)));
  inbox.close(1);
  EXPECT_FALSE(inbox.wanted(1));
  EXPECT_FALSE(inbox.put(message(1, 2)));
  inbox.set_subscribers(1, 3);
  EXPECT_FALSE(inbox.wanted(1));
  EXPECT_EQ(inbox.take(), nullptr);
}

TEST(MetricsTest, TextFormat) {
  Metrics metrics;
  metrics.counter("frames_total", "Frames so far.");
  metrics.sample(12);
  metrics.gauge("stage_ms", "Time of a \\ stage\nin ms.");
  metrics.sample(0.1, {{"stage", "match"}, {"note", "a \"b\" \\ c\nd"}});
  metrics.sample(1e300, {{"stage", "flow"}});
  metrics.sample(NAN);
  metrics.sample(INFINITY);
  metrics.sample(-INFINITY);
  EXPECT_EQ(metrics.text(),
            "# HELP frames_total Frames so far.\n# TYPE frames_total counter\nframes_total 12\n"
            "# HELP stage_ms Time of a \\\\ stage\\nin ms.\n# TYPE stage_ms gauge\n"
            "stage_ms{stage=\"match\",note=\"a \\\"b\\\" \\\\ c\\nd\"} 0.1\n"
            "stage_ms{stage=\"flow\"} 1e+300\nstage_ms NaN\nstage_ms +Inf\nstage_ms -Inf\n");
}

TEST(MetricsTest, NamesThatAreNone) {
  Metrics metrics;
  EXPECT_THROW(metrics.sample(1), ConfigError);
  for (const char* name : {"", "1st", "a-b", "a b", "ä"}) {
    EXPECT_THROW(metrics.counter(name, ""), ConfigError) << name;
  }
  metrics.gauge("a:b_1", "");
  EXPECT_THROW(metrics.gauge("a:b_1", ""), ConfigError);
  for (const char* label : {"", "a:b", "__a", "0", "a=\""})
    EXPECT_THROW(metrics.sample(1, {{label, "x"}}), ConfigError);
}

}  // namespace
}  // namespace stereogrid::server::testing
