// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/frame_queue.hpp"

#include <atomic>
#include <chrono>
#include <thread>

#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

/// Frames that take a while to load, frame 3 a long one; `bad` ones fail.
class SlowSource final : public FrameSource {
 public:
  explicit SlowSource(std::size_t count) : count_{count} {}

  [[nodiscard]] const Rig& rig() const override { return rig_; }
  [[nodiscard]] std::size_t size() const override { return count_; }
  [[nodiscard]] std::string name(std::size_t index) const override { return "f" + std::to_string(index); }
  [[nodiscard]] StereoFrame load(std::size_t index) const override {
    ++begun;
    std::this_thread::sleep_for(std::chrono::milliseconds{index == 3 ? 20 : 1});
    while (index == held) std::this_thread::sleep_for(std::chrono::milliseconds{1});
    ++loads;
    if (index == bad) throw InputError{name(index) + " is damaged"};
    if (index == broken) throw std::logic_error{"a bug"};
    StereoFrame frame;
    frame.index = static_cast<std::int64_t>(index);
    frame.left = Image<std::uint8_t>{8, 8, static_cast<std::uint8_t>(index)};
    return frame;
  }

  std::size_t bad{1000};
  std::size_t broken{1000};
  std::atomic<std::size_t> held{1000};  ///< until it is another one
  mutable std::atomic<std::size_t> begun{0};
  mutable std::atomic<std::size_t> loads{0};

 private:
  Rig rig_;
  std::size_t count_;
};

TEST(FrameQueue, KeepsTheOrderWhateverTheThreadsAndTheCapacity) {
  const SlowSource source{20};
  for (const int threads : {1, 2, 5}) {
    for (const std::size_t capacity : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{50}}) {
      FrameQueue queue{source, 0, 20, capacity, threads};
      for (std::size_t i{0}; i < 20; ++i) {
        const auto item{queue.next()};
        ASSERT_TRUE(item && item->frame);
        EXPECT_EQ(item->index, i);
        EXPECT_EQ(item->name, source.name(i));
        EXPECT_EQ(item->frame->left(0, 0), i);
      }
      EXPECT_FALSE(queue.next());
      EXPECT_FALSE(queue.next()) << "the end stays the end";
    }
  }
}

TEST(FrameQueue, WaitsNoLongerThanItIsAllowedTo) {
  using std::chrono::milliseconds;
  SlowSource source{2};
  source.held = 1;
  FrameQueue queue{source, 0, 2};
  EXPECT_TRUE(queue.is_ready_within(milliseconds{10'000}));
  EXPECT_EQ(queue.next()->index, 0U);
  EXPECT_FALSE(queue.is_ready_within(milliseconds{1}));
  source.held = 1000;
  EXPECT_TRUE(queue.is_ready_within(milliseconds{10'000}));
  EXPECT_EQ(queue.next()->index, 1U);
  EXPECT_TRUE(queue.is_ready_within(milliseconds{0})) << "the end is known";
}

TEST(FrameQueue, StopsOnceTheFrameInWorkIsLoaded) {
  SlowSource source{5};
  source.held = 0;
  FrameQueue queue{source, 0, 5};
  while (source.begun == 0) std::this_thread::yield();
  EXPECT_FALSE(queue.stop_within(std::chrono::milliseconds{1}));
  source.held = 1000;
  EXPECT_TRUE(queue.stop_within(std::chrono::milliseconds{10'000}));
  EXPECT_EQ(source.loads, 1U);
}

TEST(FrameQueue, TakesARangeAndStopsAtTheSourcesEnd) {
  const SlowSource source{6};
  FrameQueue queue{source, 4, 100};
  EXPECT_EQ(queue.next()->index, 4U);
  EXPECT_EQ(queue.next()->index, 5U);
  EXPECT_FALSE(queue.next());
  FrameQueue nothing{source, 6, 6};
  EXPECT_FALSE(nothing.next());
}

TEST(FrameQueue, PreparesFramesInTheirOrder) {
  SlowSource source{20};
  source.bad = 7;
  for (const int threads : {1, 2, 5}) {
    std::vector<std::string> seen;
    std::atomic<int> inside{0};
    FrameQueue queue{source, 0, 20, 3, threads, [&](QueuedFrame& queued) {
                       EXPECT_EQ(++inside, 1) << "one at a time";
                       seen.push_back(queued.name);
                       std::this_thread::sleep_for(std::chrono::milliseconds{queued.index % 3});
                       queued.warning = "prepared " + queued.name;
                       --inside;
                       if (queued.index == 11) throw InputError{"cannot be prepared"};
                     }};
    for (std::size_t i{0}; i < 20; ++i) {
      const auto item{queue.next()};
      ASSERT_TRUE(item);
      EXPECT_EQ(item->index, i);
      EXPECT_EQ(item->frame.has_value(), i != 7 && i != 11) << i;
      EXPECT_EQ(item->warning.value_or(""), i == 7 ? "" : "prepared " + source.name(i));
      EXPECT_EQ(item->prepared_ms > 0, i != 7);
      EXPECT_EQ(item->error, i == 7 ? "f7 is damaged" : i == 11 ? "cannot be prepared" : "");
    }
    ASSERT_EQ(seen.size(), 19U) << "without the one that could not be loaded";
    for (std::size_t i{0}; i < 19; ++i) EXPECT_EQ(seen[i], source.name(i < 7 ? i : i + 1));
  }
}

TEST(FrameQueue, ABugInThePreparationIsThrownOn) {
  const SlowSource source{6};
  FrameQueue queue{source, 0, 6, 4, 2, [](QueuedFrame& queued) {
                     if (queued.index == 2) throw std::logic_error{"a bug"};
                   }};
  EXPECT_TRUE(queue.next());
  EXPECT_TRUE(queue.next());
  EXPECT_THROW(static_cast<void>(queue.next()), std::logic_error);
}

TEST(FrameQueue, MayEndWhileFramesAreBeingPrepared) {
  const SlowSource source{50};
  std::atomic<int> prepared{0};
  {
    FrameQueue queue{source, 0, 50, 10, 3, [&](QueuedFrame&) {
                       std::this_thread::sleep_for(std::chrono::milliseconds{5});
                       ++prepared;
                     }};
    EXPECT_TRUE(queue.next());
  }
  EXPECT_LT(prepared, 50);
}

TEST(FrameQueue, ABadFrameComesInItsPlace) {
  SlowSource source{9};
  source.bad = 4;
  FrameQueue queue{source, 0, 9, 4, 2};
  for (std::size_t i{0}; i < 9; ++i) {
    const auto item{queue.next()};
    ASSERT_TRUE(item);
    EXPECT_EQ(item->index, i);
    EXPECT_EQ(item->frame.has_value(), i != 4);
    EXPECT_EQ(item->error, i == 4 ? "f4 is damaged" : "");
  }
  EXPECT_FALSE(queue.next());
}

TEST(FrameQueue, OtherExceptionsAreThrownAgain) {
  SlowSource source{5};
  source.broken = 1;
  FrameQueue queue{source, 0, 5};
  EXPECT_EQ(queue.next()->index, 0U);
  EXPECT_THROW(static_cast<void>(queue.next()), std::logic_error);
  EXPECT_EQ(queue.next()->index, 2U);
}

TEST(FrameQueue, LoadsNoMoreThanItsCapacityAhead) {
  const SlowSource source{50};
  FrameQueue queue{source, 0, 50, 3, 2};
  std::this_thread::sleep_for(std::chrono::milliseconds{60});
  EXPECT_EQ(source.loads, 3U);
  static_cast<void>(queue.next());
  std::this_thread::sleep_for(std::chrono::milliseconds{60});
  EXPECT_EQ(source.loads, 4U);
}

TEST(FrameQueue, StopsEarly) {
  const SlowSource source{100000};
  for (const int taken : {0, 1, 5}) {
    FrameQueue queue{source, 0, 100000, 4, 3};
    for (int i{0}; i < taken; ++i) static_cast<void>(queue.next());
  }
  EXPECT_LT(source.loads, 100U);
}

}  // namespace
}  // namespace stereogrid::io::testing
