// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

TEST(Swapped, IsSeenOnTexturedPairs) {
  for (const int disparity_px : {4, 17, 60}) {
    StereoFrame frame{textured_pair(641, 239, disparity_px)};
    EXPECT_FALSE(complaint_if_swapped(frame)) << disparity_px;
    std::swap(frame.left, frame.right);
    const auto complaint{complaint_if_swapped(frame)};
    ASSERT_TRUE(complaint) << disparity_px;
    EXPECT_THAT(*complaint, ::testing::HasSubstr("swapped"));
  }
}

TEST(Swapped, IsNotClaimedWhereNothingCanBeSeen) {
  StereoFrame frame;
  EXPECT_FALSE(complaint_if_swapped(frame)) << "no images";
  frame.left = frame.right = Image<std::uint8_t>{640, 240, 128};
  EXPECT_FALSE(complaint_if_swapped(frame)) << "no texture";
  frame.left = textured_pair(640, 240, 3, 1).left;
  frame.right = textured_pair(640, 240, 3, 2).left;
  EXPECT_FALSE(complaint_if_swapped(frame)) << "two images that have nothing in common";
  EXPECT_FALSE(complaint_if_swapped(textured_pair(640, 240, 0))) << "all at infinity";
  EXPECT_FALSE(complaint_if_swapped(textured_pair(20, 12, 2))) << "too small to tell";
}

}  // namespace
}  // namespace stereogrid::io::testing
