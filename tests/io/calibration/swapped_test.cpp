// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

TEST(Swapped, IsSeenOnTexturedPairs) {
  for (const int disparity_px : {4, 17, 60}) {
    StereoFrame frame{textured_pair(641, 239, disparity_px)};
    EXPECT_FALSE(finding_if_swapped(frame)) << disparity_px;
    std::swap(frame.left, frame.right);
    const auto error_text{finding_if_swapped(frame)};
    ASSERT_TRUE(error_text) << disparity_px;
    EXPECT_THAT(*error_text, ::testing::HasSubstr("swapped"));
  }
}

// Far above, near below, the right image 20 px off: the farthest points have −10 px.
TEST(Swapped, AShiftedRightImageIsNone) {
  const StereoFrame far{textured_pair(641, 240, 10)};
  const StereoFrame near{textured_pair(641, 240, 30)};
  StereoFrame frame{far};
  const auto set_below{[](Image<std::uint8_t>& to, const Image<std::uint8_t>& from) {
    for (int v{120}; v < 240; ++v) std::copy_n(from.row(v), from.width(), to.row(v));
  }};
  set_below(frame.left, near.left);
  set_below(frame.right, near.right);
  Rig rig;
  rig.cx_px = 320;
  EXPECT_FALSE(finding_if_shifted(frame, rig));
  for (int v{0}; v < 240; ++v) {
    auto* const row{frame.right.row(v)};
    std::rotate(row, row + 641 - 20, row + 641);
  }
  const auto shift_px{negative_disparity_px(frame)};
  ASSERT_TRUE(shift_px);
  EXPECT_NEAR(*shift_px, -10, 0.5);
  EXPECT_THAT(*finding_if_shifted(frame, rig), ::testing::HasSubstr("'cx_right_px: 330"));
  EXPECT_FALSE(finding_if_swapped(frame));
}

TEST(Swapped, IsNotClaimedWhereNothingCanBeSeen) {
  StereoFrame frame;
  EXPECT_FALSE(finding_if_swapped(frame)) << "no images";
  frame.left = frame.right = Image<std::uint8_t>{640, 240, 128};
  EXPECT_FALSE(finding_if_swapped(frame)) << "no texture";
  frame.left = textured_pair(640, 240, 3, 1).left;
  frame.right = textured_pair(640, 240, 3, 2).left;
  EXPECT_FALSE(finding_if_swapped(frame)) << "two images that have nothing in common";
  EXPECT_FALSE(finding_if_swapped(textured_pair(640, 240, 0))) << "all at infinity";
  EXPECT_FALSE(finding_if_swapped(textured_pair(20, 12, 2))) << "too small to tell";
}

}  // namespace
}  // namespace stereogrid::io::testing
