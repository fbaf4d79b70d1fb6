// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "clamped_to_int.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stereogrid::test {
namespace {

TEST(ClampedToInt, IsTheCastWhereThatIsDefined) {
  for (const double value : {0.0, -0.0, 0.999, -0.999, 1.0, -1.5, 16383.7, -5e8, 999'999'999.9, -999'999'999.9}) {
    EXPECT_EQ(clamped_to_int(value), static_cast<int>(value)) << value;
  }
}

TEST(ClampedToInt, EndsWhereTwoOfThemAndAnIndexCanStillBeAdded) {
  constexpr double infinity{std::numeric_limits<double>::infinity()};
  for (const double value : {1e9, 2147483647.0, 2147483648.0, 1e300, infinity}) {
    EXPECT_EQ(clamped_to_int(value), far_int) << value;
    EXPECT_EQ(clamped_to_int(-value), -far_int) << value;
  }
  EXPECT_LT(2LL * far_int + 100'000'000, std::numeric_limits<int>::max());
}

TEST(ClampedToInt, OfNoNumberIsZero) {
  EXPECT_EQ(clamped_to_int(std::nan("")), 0);
  EXPECT_EQ(clamped_to_int(std::nan(""), 5), 0);
}

TEST(ClampedToInt, TakesAnotherLimit) {
  EXPECT_EQ(clamped_to_int(4.9, 5), 4);
  EXPECT_EQ(clamped_to_int(5.9, 5), 5);
  EXPECT_EQ(clamped_to_int(-7, 5), -5);
}

}  // namespace
}  // namespace stereogrid::test
