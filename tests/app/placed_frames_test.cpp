// SPDX-License-Identifier: Apache-2.0
#include "live/live.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <future>
#include <limits>
#include <stdexcept>

#include "stereogrid/error.hpp"

namespace stereogrid::app::testing {
namespace {

using namespace std::chrono_literals;
using capture::Drop;
using capture::LiveFrame;

constexpr Rig rig{.width_px = 64, .height_px = 48, .focal_px = 50, .cx_px = 32, .cy_px = 24, .baseline_m = 0.1};

LiveFrame frame(int index, bool resets_before = false, int width = rig.width_px) {
  LiveFrame live;
  live.frame.index = index;
  live.frame.stamp_ns = index * std::int64_t{33'000'000};
  live.frame.left = live.frame.right = Image<std::uint8_t>(width, rig.height_px);
  live.captured = capture::Clock::now();
  live.resets_before = resets_before;
  return live;
}

/// Gives a list of frames as fast as they are taken, and says when all are.
class ListedFrames final : public capture::LiveSource {
 public:
  explicit ListedFrames(std::deque<LiveFrame> frames, bool breaks = false)
      : frames_{std::move(frames)}, breaks_{breaks} {}

  [[nodiscard]] const Rig& rig() const override { return testing::rig; }
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds) override {
    if (taken_ >= held_after_) {
      std::this_thread::sleep_for(1ms);
      return std::nullopt;
    }
    ++taken_;
    if (frames_.empty()) {
      given_.set_value();
      has_ended_ = true;
      if (breaks_) throw std::runtime_error{"the camera burns"};
      return std::nullopt;
    }
    LiveFrame first{std::move(frames_.front())};
    frames_.pop_front();
    if (first.frame.left.empty()) throw InputError{"a torn image"};
    return first;
  }
  [[nodiscard]] bool has_ended() const override { return has_ended_; }
  [[nodiscard]] std::string fault() const override { return ""; }
  [[nodiscard]] std::vector<Drop> dropped() const override { return {{"torn", 1}}; }

  void wait() { given_.get_future().wait(); }
  /// Holds back further frames after this number, of all.
  void hold_after(int frames) { held_after_ = frames; }

 private:
  std::deque<LiveFrame> frames_;
  bool breaks_;
  int taken_{0};
  std::atomic<int> held_after_{std::numeric_limits<int>::max()};
  std::atomic<bool> has_ended_{false};
  std::promise<void> given_;
};

/// The input, and the source once more.
struct Listed {
  explicit Listed(std::deque<LiveFrame> frames, PoseSource poses, bool breaks = false) {
    auto made{std::make_unique<ListedFrames>(std::move(frames), breaks)};
    source = made.get();
    input.source = std::move(made);
    input.poses = poses;
  }
  LiveInput input;
  ListedFrames* source{nullptr};
};

std::map<std::string, std::int64_t> counts(const PlacedFrames& frames) {
  std::map<std::string, std::int64_t> counted;
  for (const Drop& drop : frames.dropped()) counted[drop.reason] = drop.frames;
  return counted;
}

TEST(PlacedFrames, TheNewestWaitsAndReportsWhatAnEarlierOneBegan) {
  Listed listed{{frame(0), frame(1), frame(2, true), frame(3)}, PoseSource::odometry};
  PlacedFrames frames{listed.input};
  listed.source->wait();
  const std::optional<capture::PreparedFrame> last{frames.next(1s)};
  ASSERT_TRUE(last);
  EXPECT_EQ(last->frame.index, 3);
  EXPECT_TRUE(last->resets_before);  // frame 2 does, which was dropped
  EXPECT_TRUE(last->odometry_ms);
  EXPECT_TRUE(last->frame.world_from_vehicle);
  EXPECT_EQ(counts(frames)["the pipeline was busy"], 3);
  EXPECT_FALSE(frames.next(1s));
  EXPECT_TRUE(frames.has_ended());
}

TEST(PlacedFrames, RestartsOnRequest) {
  Listed listed{{frame(0), frame(1)}, PoseSource::none};
  listed.source->hold_after(1);
  PlacedFrames frames{listed.input};
  const std::optional<capture::PreparedFrame> before{frames.next(1s)};
  frames.request_reset();
  listed.source->hold_after(2);
  const std::optional<capture::PreparedFrame> after{frames.next(1s)};
  ASSERT_TRUE(before && after);
  EXPECT_TRUE(after->resets_before);
  EXPECT_FALSE(after->odometry_ms);
  EXPECT_FALSE(after->frame.world_from_vehicle);
}

TEST(PlacedFrames, CountsWhatCannotBeUsedAndGoesOn) {
  Listed listed{{LiveFrame{}, frame(1, false, 80), frame(2)}, PoseSource::odometry};
  PlacedFrames frames{listed.input};
  listed.source->wait();
  const std::optional<capture::PreparedFrame> last{frames.next(1s)};
  ASSERT_TRUE(last);
  EXPECT_EQ(last->frame.index, 2);
  EXPECT_EQ(counts(frames), (std::map<std::string, std::int64_t>{{"torn", 1}, {"do not fit the odometry", 1}}));
}

TEST(PlacedFrames, AFailureComesAfterTheLastFrame) {
  Listed listed{{frame(0)}, PoseSource::odometry, true};
  PlacedFrames frames{listed.input};
  listed.source->wait();
  EXPECT_TRUE(frames.next(1s));
  EXPECT_FALSE(frames.has_ended());
  EXPECT_THROW((void)frames.next(1s), std::runtime_error);
  EXPECT_TRUE(frames.has_ended());
}

}  // namespace
}  // namespace stereogrid::app::testing
