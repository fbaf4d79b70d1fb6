// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "support.hpp"

namespace stereogrid::capture::testing {
namespace {

using ::testing::AllOf, ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty, ::testing::SizeIs,
    ::testing::StartsWith, ::testing::ThrowsMessage;

constexpr const char* left_alone{"left image without a right one"};
constexpr const char* right_alone{"right image without a left one"};

/// Images say by their level which they are.
void add(CameraPair& pair, Side side, Clock::time_point captured, std::uint8_t level) {
  pair.add(side, view(plain(level)), captured);
}

TEST(CameraPair, JoinsImagesOfOneInstant) {
  CameraPair pair{small_calibration()};
  const auto now{Clock::now()};
  add(pair, Side::left, now, 10);
  EXPECT_FALSE(pair.next(0ms));
  add(pair, Side::right, now, 20);
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.left, plain(10));
  EXPECT_EQ(frame->frame.right, plain(20));
  EXPECT_EQ(frame->captured, now);
  const auto unix_now{std::chrono::system_clock::now().time_since_epoch()};
  EXPECT_NEAR(static_cast<double>(frame->frame.stamp_ns) * 1e-9, std::chrono::duration<double>{unix_now}.count(), 5);
  EXPECT_THAT(pair.dropped(), IsEmpty());
}

TEST(CameraPair, TakesTheNearestWithinTheTolerance) {
  CameraPair pair{small_calibration(), {.tolerance = 5ms}};
  const auto start{Clock::now()};
  add(pair, Side::right, start, 1);
  add(pair, Side::right, start + 33ms, 2);
  add(pair, Side::left, start + 29ms, 3);
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.right, plain(2));
  EXPECT_EQ(frame->captured, start + 29ms);  // the left one's, whichever came first
  EXPECT_EQ(dropped(pair, right_alone), 1);
  add(pair, Side::left, start + 66ms, 4);
  add(pair, Side::right, start + 72ms, 5);
  EXPECT_FALSE(pair.next(0ms)) << "6 ms apart";
}

TEST(CameraPair, HasOneWaitingOnly) {
  CameraPair pair{small_calibration()};
  const auto start{Clock::now()};
  for (int i{0}; i < 10; ++i) {
    const auto level{static_cast<std::uint8_t>(i)};
    pair.add(view(plain(level)), view(plain(level)), start + i * 10ms);
  }
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.left, plain(9));
  EXPECT_FALSE(pair.next(0ms));
  EXPECT_EQ(dropped(pair, "a newer one came"), 9);
}

TEST(CameraPair, CountsImagesOfOneCameraAlone) {
  CameraPair pair{small_calibration()};
  const auto start{Clock::now()};
  for (int i{0}; i < 100; ++i) add(pair, Side::left, start + i * 10ms, 0);
  EXPECT_EQ(dropped(pair, left_alone), 92);  // eight wait for the other camera
}

TEST(CameraPair, GivesNoFrameThatIsNotNewer) {
  CameraPair pair{small_calibration()};
  const auto start{Clock::now()};
  pair.add(view(plain(1)), view(plain(1)), start);
  ASSERT_TRUE(pair.next(0ms));
  pair.add(view(plain(2)), view(plain(2)), start);
  EXPECT_FALSE(pair.next(0ms));
  EXPECT_EQ(dropped(pair, "not newer than the one before"), 1);
}

TEST(CameraPair, TakesDepthInsteadOfRightImages) {
  CameraPair pair{small_calibration(), {.has_depth = true}};
  const Rig& rig{pair.rig()};
  Image<float> depth_m{width_px, height_px, 2.0F};
  depth_m(3, 4) = 0;
  const auto now{Clock::now()};
  pair.add_depth(depth_m, now);
  add(pair, Side::left, now + 1ms, 10);
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->captured, now + 1ms);
  EXPECT_EQ(frame->frame.left, plain(10));
  EXPECT_TRUE(frame->frame.right.empty());
  EXPECT_FLOAT_EQ(frame->frame.disparity(0, 0), static_cast<float>(rig.focal_px * rig.baseline_m / 2));
  EXPECT_EQ(frame->frame.disparity(3, 4), 0);
  EXPECT_THROW(pair.add_depth(Image<float>{width_px, height_px - 1}, now), InputError);
  for (int i{0}; i < 10; ++i) pair.add_depth(depth_m, now + 50ms + i * 50ms);
  EXPECT_EQ(dropped(pair, "depth without a left image"), 2);
}

TEST(CameraPair, SplitsImagesSideBySide) {
  CameraPair pair{small_calibration()};
  constexpr int channels{3};
  constexpr int row_bytes{2 * width_px * channels + 5};  // rows of a camera may end in a gap
  std::vector<std::uint8_t> bytes(std::size_t{row_bytes} * height_px, 7);
  for (const auto [u, v] : raster(2 * width_px * channels, height_px))
    bytes[v * row_bytes + u] = u < width_px * channels ? 100 : 200;
  pair.add_side_by_side({bytes.data(), 2 * width_px, height_px, row_bytes, PixelFormat::bgr8}, Clock::now());
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.left, plain(100));
  EXPECT_EQ(frame->frame.right, plain(200));
}

TEST(CameraPair, SplitsImagesWithoutGaps) {
  CameraPair pair{small_calibration()};
  Image<std::uint8_t> both{plain(50, 2 * width_px)};
  for (int v{0}; v < height_px; ++v) std::fill_n(both.row(v) + width_px, width_px, std::uint8_t{60});
  pair.add_side_by_side(view(both), Clock::now());
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.left, plain(50));
  EXPECT_EQ(frame->frame.right, plain(60));
}

/// 16-bit samples, all equal, with unknown bits.
struct Deep {
  explicit Deep(std::uint16_t level) : samples(std::size_t{width_px} * height_px, level) {}
  [[nodiscard]] PixelView view() const { return {samples.data(), width_px, height_px, 0, PixelFormat::grey16, 0}; }
  std::vector<std::uint16_t> samples;
};

TEST(CameraPair, FindsOneScaleForBothImagesOfSixteenBits) {
  CameraPair pair{small_calibration()};
  const auto start{Clock::now()};
  auto levels = [&, i = 0](std::uint16_t left, std::uint16_t right) mutable {
    const auto captured{start + ++i * 10ms};
    pair.add(Side::right, Deep{right}.view(), captured);
    pair.add(Side::left, Deep{left}.view(), captured);
    const auto frame{pair.next(0ms)};
    return frame ? std::pair{int{frame->frame.left(0, 0)}, int{frame->frame.right(0, 0)}} : std::pair{-1, -1};
  };
  EXPECT_EQ(levels(1000, 1200), (std::pair{125, 150})) << "a dark start";
  EXPECT_EQ(levels(60000, 40000), (std::pair{234, 156})) << "not saturated";
  EXPECT_EQ(levels(20000, 20000), (std::pair{78, 78})) << "the scale stays";
  EXPECT_EQ(levels(1000, 1000), (std::pair{62, 62})) << "but for very dark pairs";
}

TEST(CameraPair, RectifiesWhatIsRaw) {
  io::Calibration calibration{small_calibration()};
  const io::CameraModel camera{30, 30, 15.5, 7.5, {0.1, 0, 0, 0}};
  calibration.raw = io::RawPair{camera, camera, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {-0.1, 0, 0}};
  CameraPair pair{calibration};
  Image<std::uint8_t> image{plain(0)};
  for (const auto [u, v] : raster(width_px, height_px)) image(u, v) = static_cast<std::uint8_t>(8 * u);
  pair.add(view(image), view(image), Clock::now());
  const auto frame{pair.next(0ms)};
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.left, (io::Rectifier{*calibration.raw, width_px, height_px}.left(image)));
  EXPECT_NE(frame->frame.left, image);
}

TEST(CameraPair, RefusesImagesOfAnotherSize) {
  CameraPair pair{small_calibration()};
  EXPECT_THAT([&] { pair.add(Side::left, view(plain(0, 30, 16)), Clock::now()); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("30×16"), HasSubstr("32×16"), HasSubstr("calibrate"))));
}

TEST(CameraPair, RefusesACalibrationWithoutSize) {
  io::Calibration calibration{small_calibration()};
  calibration.rig.width_px = 0;
  EXPECT_THROW(CameraPair{calibration}, InputError);
}

TEST(CameraPair, SaysWhichCameraIsSilent) {
  CameraPair pair{small_calibration(), {.silence = 100ms}};
  EXPECT_EQ(pair.fault(), "");
  std::this_thread::sleep_for(150ms);
  EXPECT_THAT(pair.fault(), HasSubstr("either camera"));
  add(pair, Side::left, Clock::now(), 0);
  EXPECT_THAT(pair.fault(), HasSubstr("right camera"));
  add(pair, Side::right, Clock::now() + 45ms, 0);
  EXPECT_THAT(pair.fault(), AllOf(HasSubstr("tolerance of 10.0 ms"), HasSubstr("--pair-tolerance-ms")));
  const auto now{Clock::now() + 1s};
  add(pair, Side::left, now, 0);
  add(pair, Side::right, now, 0);
  EXPECT_EQ(pair.fault(), "");
}

TEST(CameraPair, KeepsAFaultUntilTheNextPair) {
  CameraPair pair{small_calibration()};
  pair.set_fault("lost");
  EXPECT_EQ(pair.fault(), "lost");
  add(pair, Side::left, Clock::now(), 0);
  EXPECT_EQ(pair.fault(), "lost");
  pair.add(view(plain(1)), view(plain(1)), Clock::now());
  EXPECT_EQ(pair.fault(), "");
}

TEST(CameraPair, EndsOnceTheLastFrameIsTaken) {
  CameraPair pair{small_calibration()};
  pair.add(view(plain(1)), view(plain(1)), Clock::now());
  pair.end();
  EXPECT_FALSE(pair.has_ended());
  EXPECT_TRUE(pair.next(0ms));
  EXPECT_TRUE(pair.has_ended());
}

TEST(CameraPair, ReportsANewStreamThoughItsFirstFrameIsLost) {
  CameraPair pair{small_calibration()};
  const auto start{Clock::now()};
  pair.add(view(plain(1)), view(plain(1)), start);
  EXPECT_FALSE(pair.next(0ms)->resets_before);
  pair.request_reset();
  pair.add(view(plain(2)), view(plain(2)), start + 1ms);
  pair.add(view(plain(3)), view(plain(3)), start + 2ms);
  EXPECT_TRUE(pair.next(0ms)->resets_before);
  pair.add(view(plain(4)), view(plain(4)), start + 3ms);
  EXPECT_FALSE(pair.next(0ms)->resets_before);
}

/// Two stereo pairs of one vehicle, with stamps of the test's.
class CameraSet : public ::testing::Test {
 protected:
  CameraSet() {
    std::vector<NamedSource> cameras;
    for (const char* name : {"front", "rear"}) {
      io::Calibration calibration{small_calibration()};
      if (!pairs_.empty()) calibration.rig.width_px = 2 * width_px;  // sizes may differ
      auto pair{std::make_unique<CameraPair>(calibration)};
      pairs_.push_back(pair.get());
      cameras.push_back({name, std::move(pair)});
    }
    set_ = join_cameras(std::move(cameras));
  }

  void add(std::size_t camera, std::chrono::milliseconds at) {
    const Image<std::uint8_t> image{plain(7, pairs_[camera]->rig().width_px)};
    pairs_[camera]->add(view(image), view(image), start_ + at);
  }
  /// Both cameras' frames each 100 ms before `at`.
  void run_until(std::chrono::milliseconds at) {
    for (std::chrono::milliseconds now{0}; now < at; now += 100ms) {
      add(0, now);
      add(1, now + 10ms);
      const auto live{wait_for_frame(*set_)};
      ASSERT_TRUE(live);
      ASSERT_THAT(live->frame.others, SizeIs(1));
    }
  }
  const Clock::time_point start_{Clock::now()};
  std::vector<CameraPair*> pairs_;
  std::unique_ptr<LiveSource> set_;
};

TEST_F(CameraSet, HasTheFramesOfOneInstant) {
  EXPECT_EQ(set_->rigs().size(), 2U);
  EXPECT_EQ(set_->rigs()[1].width_px, 2 * width_px);
  add(0, 0ms);
  add(1, 10ms);
  const auto live{wait_for_frame(*set_)};
  ASSERT_TRUE(live);
  EXPECT_EQ(live->frame.camera, 0);
  ASSERT_THAT(live->frame.others, SizeIs(1));
  EXPECT_EQ(live->frame.others[0].camera, 1);
  EXPECT_NEAR(static_cast<double>(live->frame.others[0].stamp_ns - live->frame.stamp_ns), 10e6, 1e3);
  add(0, 100ms);
  EXPECT_FALSE(set_->next(0ms)) << "the rear camera's frame is due";
  add(1, 110ms);
  EXPECT_THAT(wait_for_frame(*set_)->frame.others, SizeIs(1));
}

TEST_F(CameraSet, UsesAFrameOfASlowerCameraOnce) {
  run_until(200ms);
  std::vector<std::size_t> others;
  for (int i{0}; i < 12; ++i) {  // every 25 and 100 ms
    add(0, 200ms + i * 25ms);
    if (i % 4 == 0) add(1, 200ms + i * 25ms);
    others.push_back(wait_for_frame(*set_)->frame.others.size());
  }
  EXPECT_THAT(others, ElementsAre(1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0));
}

TEST_F(CameraSet, CountsFramesOfAFasterCameraThatAreNotUsed) {
  run_until(200ms);
  for (int i{0}; i < 3; ++i) {  // every 100 and 50 ms
    for (const auto later : {0ms, 50ms}) {
      add(1, 200ms + i * 100ms + later);
      EXPECT_FALSE(set_->next(0ms));
    }
    add(0, 250ms + i * 100ms);
    EXPECT_THAT(wait_for_frame(*set_)->frame.others, SizeIs(1));
  }
  EXPECT_EQ(dropped(*set_, "no frame of the first camera beside it"), 3);
}

TEST_F(CameraSet, GoesOnWithoutACameraThatStops) {
  run_until(300ms);
  for (int i{0}; i < 3; ++i) {
    add(0, 300ms + i * 100ms);
    EXPECT_THAT(wait_for_frame(*set_)->frame.others, IsEmpty());
  }
  EXPECT_TRUE(becomes([&] { return !set_->fault().empty(); }));
  EXPECT_THAT(set_->fault(), StartsWith("rear: "));
}

TEST_F(CameraSet, GoesOnWithoutTheFirstCameraUntilItIsBack) {
  run_until(300ms);
  add(1, 310ms);
  const auto alone{wait_for_frame(*set_)};
  ASSERT_TRUE(alone);
  EXPECT_TRUE(alone->frame.left.empty());
  ASSERT_THAT(alone->frame.others, SizeIs(1));
  EXPECT_EQ(alone->frame.others[0].camera, 1);
  EXPECT_EQ(alone->frame.others[0].stamp_ns, alone->frame.stamp_ns);
  EXPECT_FALSE(alone->resets_before);
  add(0, 400ms);
  add(1, 410ms);
  const auto both{wait_for_frame(*set_)};
  EXPECT_FALSE(both->frame.left.empty());
  EXPECT_THAT(both->frame.others, SizeIs(1));
}

TEST_F(CameraSet, NamesACameraOfAnotherClock) {
  int i{0};
  EXPECT_TRUE(becomes([&] {
    add(0, i * 100ms);
    add(1, i * 100ms + 5s);
    ++i;
    EXPECT_THAT(wait_for_frame(*set_)->frame.others, IsEmpty());
    return set_->fault().find("rear: its stamps are +5.0 s from those of front") == 0;
  }));
}

TEST_F(CameraSet, FollowsTheFirstCameraBackFromAnotherClock) {
  add(0, 0ms);
  add(1, 20s);
  ASSERT_TRUE(wait_for_frame(*set_));
  const auto alone{wait_for_frame(*set_)};  // the first one has stopped
  ASSERT_TRUE(alone);
  EXPECT_TRUE(alone->frame.left.empty());
  add(0, 5s);
  const auto back{wait_for_frame(*set_)};
  ASSERT_TRUE(back);
  EXPECT_FALSE(back->frame.left.empty());
  EXPECT_TRUE(back->resets_before);
}

TEST_F(CameraSet, RestartsWithEachCamera) {
  run_until(300ms);
  pairs_[1]->request_reset();
  add(1, 310ms);
  add(0, 300ms);
  const auto live{wait_for_frame(*set_)};
  EXPECT_TRUE(live->resets_before);
  EXPECT_THAT(live->frame.others, SizeIs(1));
}

}  // namespace
}  // namespace stereogrid::capture::testing
