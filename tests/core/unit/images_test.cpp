// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/pixel_view.hpp"

#include "stereogrid/error.hpp"
#include "stereogrid/exposure.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

TEST(PixelView, GreyWithoutGapsIsCopiedIntoTheSameMemory) {
  std::mt19937 generator{3};
  const Image<std::uint8_t> image{noise_image(37, 21, generator)};
  Image<std::uint8_t> grey{37, 21, 9};
  const std::uint8_t* const before{grey.data()};
  assign(grey, {image.data(), 37, 21});
  EXPECT_EQ(grey, image);
  EXPECT_EQ(grey.data(), before);
  Image<std::uint8_t> of_another_size{3, 4};
  assign(of_another_size, {image.data(), 37, 21, 37});
  EXPECT_EQ(of_another_size, image);
}

TEST(PixelView, TakesPartsOfImagesAndImagesUpsideDown) {
  std::mt19937 generator{4};
  const Image<std::uint8_t> both{noise_image(40, 6, generator)};
  Image<std::uint8_t> part;
  assign(part, {both.row(1) + 20, 15, 4, 40});
  ASSERT_EQ(part.width(), 15);
  for (const auto [u, v] : raster(15, 4)) ASSERT_EQ(part(u, v), both(u + 20, v + 1));
  Image<std::uint8_t> upright;
  assign(upright, {both.row(5), 40, 6, -40});
  for (int v{0}; v < 6; ++v) ASSERT_EQ(upright(7, v), both(7, 5 - v));
}

// At an odd address, as a packed message may have them.
TEST(PixelView, SixteenBitsLoseTheirLowerOnesAndSaturate) {
  constexpr std::array<std::uint16_t, 6> samples{0, 15, 16, 4095, 4096, 65535};
  std::array<unsigned char, 2 * samples.size() + 1> packed{};
  std::memcpy(packed.data() + 1, samples.data(), sizeof samples);
  PixelView view{packed.data() + 1, 3, 2, 0, PixelFormat::grey16, 12};
  Image<std::uint8_t> grey;
  assign(grey, view);
  EXPECT_EQ(std::vector(grey.begin(), grey.end()), (std::vector<std::uint8_t>{0, 0, 1, 255, 255, 255}));
  view.bits = 16;
  assign(grey, view);
  EXPECT_EQ(std::vector(grey.begin(), grey.end()), (std::vector<std::uint8_t>{0, 0, 0, 15, 16, 255}));
}

TEST(PixelView, ColourIsLumaInAnyOrder) {
  constexpr std::array<unsigned char, 8> red_to_alpha{200, 100, 50, 7, 255, 255, 255, 0};
  constexpr std::array<unsigned char, 6> blue_to_red{50, 100, 200, 255, 255, 255};
  const std::vector<std::uint8_t> expected{124, 255};  // 0.299 · 200 + 0.587 · 100 + 0.114 · 50 = 124.2
  Image<std::uint8_t> grey;
  assign(grey, {red_to_alpha.data(), 2, 1, 0, PixelFormat::rgba8});
  EXPECT_EQ(std::vector(grey.begin(), grey.end()), expected);
  assign(grey, {blue_to_red.data(), 2, 1, 0, PixelFormat::bgr8});
  EXPECT_EQ(std::vector(grey.begin(), grey.end()), expected);
  assign(grey, {blue_to_red.data(), 1, 1, 0, PixelFormat::rgb8});
  EXPECT_EQ(grey(0, 0), 96);  // 0.299 · 50 + 0.587 · 100 + 0.114 · 200 = 96.45
}

TEST(PixelView, WhatCannotBeAnImageIsRefusedAndNothingHasChanged) {
  const std::array<unsigned char, 64> bytes{};
  Image<std::uint8_t> grey{2, 2, 5};
  for (const PixelView& view :
       {PixelView{bytes.data(), -1, 2}, PixelView{bytes.data(), 2, -2}, PixelView{nullptr, 2, 2},
        PixelView{bytes.data(), 4, 2, 3}, PixelView{bytes.data() + 32, 4, 2, -3},
        PixelView{bytes.data(), 4, 2, 11, PixelFormat::bgr8}, PixelView{bytes.data(), 4, 2, 7, PixelFormat::grey16},
        PixelView{bytes.data(), 2, 2, 0, static_cast<PixelFormat>(6)},
        PixelView{bytes.data(), 2, 2, 0, static_cast<PixelFormat>(-1)},
        PixelView{bytes.data(), 2, 2, 0, PixelFormat::grey16, 7},
        PixelView{bytes.data(), 2, 2, 0, PixelFormat::grey16, 17},
        PixelView{bytes.data(), 2, 2, std::numeric_limits<std::ptrdiff_t>::min()},
        PixelView{bytes.data(), 2, 3, std::numeric_limits<std::ptrdiff_t>::min() + 1},
        PixelView{bytes.data(), 2, 3, std::numeric_limits<std::ptrdiff_t>::max()}}) {
    EXPECT_THROW(assign(grey, view), InputError);
  }
  EXPECT_EQ(grey, (Image<std::uint8_t>{2, 2, 5}));
  assign(grey, {});
  EXPECT_TRUE(grey.empty());
}

void expect_same(const Pose2& a, const Pose2& b) {
  EXPECT_NEAR(a.x_m, b.x_m, 1e-12);
  EXPECT_NEAR(a.y_m, b.y_m, 1e-12);
  EXPECT_NEAR(std::remainder(a.yaw_rad - b.yaw_rad, 2 * pi), 0, 1e-12);
}

TEST(Pose, TurnsCounterClockwiseThenMoves) {
  const Pose2 world_from_vehicle{10, 20, 90 * degree};
  // 3 m ahead of a car that faces +y, and 1 m to its left, which is −x
  const Point2 in_world{world_from_vehicle * Point2{3, 1}};
  EXPECT_NEAR(in_world.x, 9, 1e-12);
  EXPECT_NEAR(in_world.y, 23, 1e-12);
}

TEST(Pose, CompositionIsOneAfterTheOther) {
  const Pose2 a_from_b{1, 2, 0.3};
  const Pose2 b_from_c{-4, 0.5, 1.1};
  const Point2 in_c{0.7, -2.2};
  const Point2 at_once{(a_from_b * b_from_c) * in_c};
  const Point2 in_steps{a_from_b * (b_from_c * in_c)};
  EXPECT_NEAR(at_once.x, in_steps.x, 1e-12);
  EXPECT_NEAR(at_once.y, in_steps.y, 1e-12);
  expect_same(Pose2{1, 2, 90 * degree} * Pose2{1, 0, 0}, {1, 3, 90 * degree});
}

TEST(Pose, CompositionKeepsTheHeadingInRange) {
  const Pose2 turned{Pose2{0, 0, 3} * Pose2{0, 0, 3}};
  EXPECT_NEAR(turned.yaw_rad, 6 - 2 * pi, 1e-12);
  const Pose2 back{Pose2{0, 0, -3} * Pose2{0, 0, -3}};
  EXPECT_NEAR(back.yaw_rad, 2 * pi - 6, 1e-12);
}

TEST(Pose, InverseUndoes) {
  std::mt19937 generator{5};
  for (int i{0}; i < 50; ++i) {
    const Pose2 a_from_b{uniform(generator, -50, 50), uniform(generator, -50, 50), uniform(generator, -3, 3)};
    expect_same(a_from_b * inverse(a_from_b), {});
    expect_same(inverse(a_from_b) * a_from_b, {});
  }
  expect_same(inverse(Pose2{1, 2, 90 * degree}), {-2, 1, -90 * degree});
}

using ::testing::HasSubstr, ::testing::Not;

int clipped(double grey) {
  return static_cast<int>(std::clamp(std::round(grey), 0.0, 255.0));
}

/// Counts of an image, and of the same image through another exposure.
struct Counts {
  explicit Counts(const std::function<double(int)>& exposed) {
    std::mt19937 generator{3};
    for (int i{0}; i < 12000; ++i) {
      const int grey{clipped(110 + 35 * gaussian(generator))};
      ++left[static_cast<std::size_t>(grey)];
      ++right[static_cast<std::size_t>(clipped(exposed(grey)))];
    }
  }
  GreyCounts left{};
  GreyCounts right{};
};

TEST(Exposure, TheTransferIsTheOneThatWasApplied) {
  const auto gain = [](int grey) { return 1.6 * grey; };
  const auto gamma = [](int grey) { return 255 * std::pow(grey / 255.0, 0.5); };
  const auto offset = [](int grey) { return grey - 60.0; };
  const auto dim = [](int grey) { return 0.3 * grey; };
  for (const std::function<double(int)>& exposed : std::vector<std::function<double(int)>>{gain, gamma, offset, dim}) {
    const Counts counts{exposed};
    const GreyTransfer transfer{transfer_of(counts.left, counts.right)};
    for (int grey{40}; grey <= 180; grey += 10) {
      EXPECT_LE(std::abs(transfer[static_cast<std::size_t>(grey)] - clipped(exposed(grey))), 1) << grey;
    }
  }
}

TEST(Exposure, TheGainIsMeasuredWhereNothingIsSaturated) {
  for (const double gain : {0.3, 0.5, 1.0, 1.4, 2.0, 3.0}) {
    const Counts counts{[gain](int grey) { return gain * grey; }};
    const Exposure exposure{exposure_of(counts.left, counts.right)};
    EXPECT_NEAR(exposure.gain, gain, 0.04 * gain);
    EXPECT_LT(exposure.left_saturated, 0.001);
    const Exposure exchanged{exposure_of(counts.right, counts.left)};
    EXPECT_NEAR(exchanged.gain, 1 / gain, 0.04 / gain);
    EXPECT_EQ(exchanged.left_saturated, exposure.right_saturated);
    const bool is_far_from_one{gain > 1.45 || gain < 1 / 1.45};
    EXPECT_EQ(is_unequal(exposure), is_far_from_one) << gain;
    EXPECT_EQ(is_unequal(exchanged), is_far_from_one) << gain;
  }
}

TEST(Exposure, SaturationCostsMatchesAtASmallGain) {
  EXPECT_TRUE(is_unequal({1.3, 0.02, 0.1}));
  EXPECT_TRUE(is_unequal({1 / 1.3, 0.1, 0.02}));
  EXPECT_FALSE(is_unequal({1.3, 0.1, 0.1})) << "the sky in both";
  EXPECT_FALSE(is_unequal({1.1, 0.0, 0.1}));
}

TEST(Exposure, ATextNamesTheBrighterSide) {
  EXPECT_EQ(text_of({1.62, 0.01, 0.34}),
            "the right image is 1.6 × brighter than the left and 35 % of it is saturated: set both cameras to the same "
            "exposure.");
  EXPECT_THAT(text_of({0.5, 0.21, 0.0}), HasSubstr("the left image is 2.0 × brighter than the right and 20 %"));
  EXPECT_THAT(text_of({0.3, 0.0, 0.0}), Not(HasSubstr("saturated")));
}

TEST(Exposure, BlackAndEmptyImagesAreNoQuestionOfIt) {
  GreyCounts black{};
  black[3] = 500;
  const Counts counts{[](int grey) { return grey; }};
  EXPECT_FALSE(is_unequal(exposure_of(counts.left, black)));
  EXPECT_FALSE(is_unequal(exposure_of(black, counts.left)));
  EXPECT_FALSE(is_unequal(exposure_of(black, black)));
  EXPECT_FALSE(is_unequal(exposure_of({}, {})));
  EXPECT_EQ(transfer_of({}, {}).front(), transfer_of({}, {}).back()) << "no pixel has a rank";
}

}  // namespace
}  // namespace stereogrid::test
