// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/capture/live_source.hpp"

#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::capture::testing {
namespace {

constexpr std::int64_t other_later_ns{3'000'000};

/// Frames of two cameras every 20 ms from a stamp far from zero; one of them is damaged.
class Drive final : public FrameSource {
 public:
  explicit Drive(std::size_t frames, std::size_t damaged = 1000) : frames_{frames}, damaged_{damaged} {}

  [[nodiscard]] const Rig& rig() const override { return rig_; }
  [[nodiscard]] std::size_t size() const override { return frames_; }
  [[nodiscard]] std::string name(std::size_t index) const override { return std::to_string(index); }
  [[nodiscard]] StereoFrame load(std::size_t index) const override {
    if (index == damaged_) throw InputError{"frame " + name(index) + " is damaged."};
    StereoFrame frame;
    frame.name = name(index);
    frame.index = static_cast<std::int64_t>(index);
    frame.stamp_ns = 5'000'000'000 + static_cast<std::int64_t>(index) * 20'000'000;
    StereoFrame& other{frame.others.emplace_back()};
    other.camera = 1;
    other.stamp_ns = frame.stamp_ns + other_later_ns;
    return frame;
  }

 private:
  Rig rig_{small_calibration().rig};
  std::size_t frames_;
  std::size_t damaged_;
};

TEST(Replay, KeepsThePaceOfTheRecording) {
  const Drive drive{11};
  const auto begun{Clock::now()};
  const auto source{replay(drive)};
  std::int64_t first_ns{0};
  std::int64_t last_ns{0};
  while (const auto frame{wait_for_frame(*source)}) {
    if (first_ns == 0) first_ns = frame->frame.stamp_ns;
    last_ns = frame->frame.stamp_ns;
    EXPECT_EQ(frame->frame.others.at(0).stamp_ns, last_ns + other_later_ns);
    EXPECT_GE(frame->captured - begun, std::chrono::nanoseconds{last_ns - first_ns} - 1ms);
  }
  EXPECT_TRUE(source->has_ended());
  EXPECT_EQ(last_ns - first_ns, 200'000'000);
  EXPECT_GE(Clock::now() - begun, 200ms);
}

TEST(Replay, IsFasterWhereThatIsAskedFor) {
  const Drive drive{101};  // 2 s
  const auto begun{Clock::now()};
  const auto source{replay(drive, {.speed = 20})};
  std::int64_t first_ns{0};
  std::int64_t last_ns{0};
  while (const auto frame{wait_for_frame(*source)}) {
    if (first_ns == 0) first_ns = frame->frame.stamp_ns;
    last_ns = frame->frame.stamp_ns;
  }
  EXPECT_LT(Clock::now() - begun, 1500ms);
  EXPECT_GT(last_ns - first_ns, 1'500'000'000) << "stamps are those of the recording";
}

TEST(Replay, LosesWhatItsReaderIsTooSlowFor) {
  const Drive drive{20};
  const auto source{replay(drive)};
  ASSERT_TRUE(wait_for_frame(*source));
  std::this_thread::sleep_for(200ms);
  const auto frame{source->next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_GT(std::stoi(frame->frame.name), 2);
  EXPECT_EQ(dropped(*source, "a newer one came"), std::stoi(frame->frame.name) - 1);
}

TEST(Replay, BeginsAgain) {
  const Drive drive{3};
  const auto source{replay(drive, {.loops = true, .speed = 10})};
  std::int64_t last_ns{0};
  int rounds{0};
  for (int i{0}; i < 12; ++i) {
    const auto frame{wait_for_frame(*source)};
    ASSERT_TRUE(frame);
    EXPECT_GT(frame->frame.stamp_ns, last_ns);
    last_ns = frame->frame.stamp_ns;
    if (frame->resets_before) ++rounds;
  }
  EXPECT_GE(rounds, 2);
  EXPECT_FALSE(source->has_ended());
}

TEST(Replay, GoesOnAfterAFrameThatCannotBeUsed) {
  const Drive drive{3, 1};
  const auto source{replay(drive)};
  EXPECT_TRUE(wait_for_frame(*source));
  EXPECT_THROW(static_cast<void>(wait_for_frame(*source)), InputError);
  EXPECT_TRUE(wait_for_frame(*source));
  EXPECT_EQ(dropped(*source, "cannot be used"), 1);
}

TEST(Replay, OfAPart) {
  const Drive drive{10};
  const auto source{replay(drive, {.first = 4, .last = 5})};
  EXPECT_EQ(wait_for_frame(*source)->frame.name, "4");
  EXPECT_FALSE(wait_for_frame(*source));
  EXPECT_THROW(static_cast<void>(replay(drive, {.first = 10})), ConfigError);
  EXPECT_THROW(static_cast<void>(replay(drive, {.speed = 0})), ConfigError);
}

}  // namespace
}  // namespace stereogrid::capture::testing
