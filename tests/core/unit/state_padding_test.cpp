// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Types that may be saved as raw memory.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <new>

#include "pipeline/saved_state.hpp"

namespace stereogrid::test {
namespace {

struct Full {
  std::int32_t first{0};
  float second{0};
  std::array<double, 2> rest{};
};
struct PaddedWithin {
  float first{0};
  double second{0};
};
struct PaddedAtItsEnd {
  double first{0};
  bool second{false};
};
struct HoldsPadding {
  std::array<PaddedAtItsEnd, 2> both{};
};

TEST(StatePadding, IsNoticed) {
  EXPECT_TRUE(HasNoPadding<Full>);
  EXPECT_TRUE(HasNoPadding<double>);
  EXPECT_FALSE(HasNoPadding<PaddedWithin>);
  EXPECT_FALSE(HasNoPadding<PaddedAtItsEnd>);
  EXPECT_FALSE(HasNoPadding<HoldsPadding>);
  EXPECT_FALSE(HasNoPadding<Ground>) << "is put member by member";
}

// The same numbers in memory that held other things before.
TEST(StatePadding, OfAGroundIsNotSaved) {
  const auto saved = [](unsigned char before) {
    alignas(Ground) std::array<unsigned char, sizeof(Ground)> memory;
    memory.fill(before);
    Ground& ground{*new (memory.data()) Ground{1.5, 0.1, 0.02, true}};
    StateWriter writer;
    writer(ground);
    return writer.bytes();
  };
  EXPECT_EQ(saved(0), saved(255));
}

}  // namespace
}  // namespace stereogrid::test
