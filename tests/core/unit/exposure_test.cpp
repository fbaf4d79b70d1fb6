// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/exposure.hpp"

#include "support.hpp"

namespace stereogrid::test {
namespace {

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
