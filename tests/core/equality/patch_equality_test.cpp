// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Patches by vectors, on every instruction set of this machine, against plain loops.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "images/patch.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

constexpr int width{64};
constexpr int height{40};
// not the width: rows must not be taken for neighbours in memory
constexpr int pitch{71};

struct Random {
  std::mt19937 generator;

  float between(float least, float most) { return std::uniform_real_distribution<float>{least, most}(generator); }
  // on a pixel now and then, in one or both directions
  float place(float most) {
    const float any{between(-3, most + 3)};
    return generator() % 3 == 0 ? std::round(any) : any;
  }
  float shear() { return generator() % 2 == 0 ? 0.0f : between(-0.8f, 0.8f); }
};

Image<std::uint8_t> smooth_noise(Random& random) {
  Image<std::uint8_t> image{pitch, height};
  for (int v{0}; v < height; ++v) {
    for (int u{0}; u < pitch; ++u) {
      const double wave{50 * std::sin(0.4 * u + 0.3 * v) + 40 * std::cos(0.5 * v - 0.2 * u)};
      image(u, v) = static_cast<std::uint8_t>(120 + wave + random.between(0, 20));
    }
  }
  return image;
}

View<const std::uint8_t> part_of(const Image<std::uint8_t>& image) {
  return {image.data(), width, height, pitch};
}

void expect_equal(const Template& expected, const Template& actual) {
  EXPECT_EQ(expected.grey, actual.grey);
  EXPECT_EQ(expected.gradient_u, actual.gradient_u);
  EXPECT_EQ(expected.gradient_v, actual.gradient_v);
  EXPECT_EQ(expected.uu, actual.uu);
  EXPECT_EQ(expected.uv, actual.uv);
  EXPECT_EQ(expected.vv, actual.vv);
  EXPECT_EQ(expected.variance, actual.variance);
}

TEST(PatchEquality, OnEveryInstructionSet) {
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    Random random{std::mt19937{7}};
    int cut_out{0};
    int found_again{0};
    const Image<std::uint8_t> image{smooth_noise(random)};
    for (int i{0}; i < 2000; ++i) {
      const Place at{random.place(width), random.place(height)};
      const float shear{random.shear()};
      Template expected;
      Template actual;
      const bool is_inside{plain::cut(part_of(image), at, shear, expected)};
      ASSERT_EQ(is_inside, cut(part_of(image), at, shear, actual)) << at.u << " " << at.v;
      if (!is_inside) continue;
      ++cut_out;
      expect_equal(expected, actual);
      const Place start{at.u + random.between(-2, 2), at.v + random.between(-2, 2)};
      const FindLimits limits{static_cast<int>(random.generator() % 6)};
      const std::optional<Place> there{plain::find(part_of(image), expected, shear, start, limits)};
      const std::optional<Place> found{find(part_of(image), actual, shear, start, limits)};
      ASSERT_EQ(there.has_value(), found.has_value());
      if (!there) continue;
      ++found_again;
      EXPECT_EQ(there->u, found->u);
      EXPECT_EQ(there->v, found->v);
    }
    EXPECT_GT(cut_out, 500);
    EXPECT_GT(found_again, 200);
  }
}

}  // namespace
}  // namespace stereogrid::test
