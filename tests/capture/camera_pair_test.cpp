// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "support.hpp"

namespace stereogrid::capture::testing {
namespace {

using ::testing::AllOf, ::testing::HasSubstr, ::testing::IsEmpty, ::testing::ThrowsMessage;

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

}  // namespace
}  // namespace stereogrid::capture::testing
