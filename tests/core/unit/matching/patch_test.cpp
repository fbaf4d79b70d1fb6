// SPDX-License-Identifier: Apache-2.0
#include "images/patch.hpp"

#include "images/patch_formulas.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr int width{80};
constexpr int height{50};

// The texture, its point (u, v) seen at (u + du, v + dv).
Image<std::uint8_t> moved(const Texture& texture, double du, double dv) {
  Image<std::uint8_t> image{width, height};
  for (const auto [u, v] : raster(width, height))
    image(u, v) = static_cast<std::uint8_t>(texture.at(u - du, v - dv) + 0.5);
  return image;
}

TEST(Patch, IsFoundToAFractionOfAPixel) {
  const Texture texture{4};
  const Image<std::uint8_t> first{moved(texture, 0, 0)};
  const Image<std::uint8_t> second{moved(texture, 1.3, -0.6)};
  for (const Place at : {Place{30, 20}, Place{41.25f, 25.5f}, Place{50.7f, 30.1f}}) {
    Template patch;
    ASSERT_TRUE(cut(first.view(), at, 0, patch));
    const std::optional<Place> found{find(second.view(), patch, 0, at, {5})};
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->u, at.u + 1.3, 0.05);
    EXPECT_NEAR(found->v, at.v - 0.6, 0.05);
  }
}

// Gradients along a diagonal: a move along one axis looks like one along the other.
TEST(Patch, StepSolvesBothAxesTogether) {
  Template patch{};
  patch.uu = 20;
  patch.vv = 30;
  patch.uv = 15;
  const Place step{step_of(patch, 20 * 0.1 + 15 * 0.3, 15 * 0.1 + 30 * 0.3)};
  EXPECT_NEAR(step.u, 0.1, 1e-6);
  EXPECT_NEAR(step.v, 0.3, 1e-6);
}

TEST(MatchLattice, HasEverySixthPixelAroundWhichAPatchFits) {
  for (const int size : {40, 41, 42, 43, 44, 45, 640}) {
    const MatchLattice lattice{size, size};
    const int after_u{MatchLattice::first_u + 6 * lattice.across};
    const int after_v{MatchLattice::first_v + 6 * lattice.down};
    EXPECT_LE(after_u - 6 + patch_reach_u, size - 1);
    EXPECT_GE(after_u + patch_reach_u, size);
    EXPECT_LE(after_v - 6 + patch_reach_v + 1, size - 1);
    EXPECT_GE(after_v + patch_reach_v + 1, size);
  }
}

TEST(Patch, IsNotFoundWhereSomethingElseIs) {
  const Image<std::uint8_t> first{moved(Texture{4}, 0, 0)};
  const Image<std::uint8_t> other{moved(Texture{5}, 0, 0)};
  Template patch;
  ASSERT_TRUE(cut(first.view(), {40, 25}, 0, patch));
  EXPECT_FALSE(find(other.view(), patch, 0, {40, 25}));
  EXPECT_TRUE(find(first.view(), patch, 0, {40, 25}));
}

TEST(Patch, MustLieInsideTheImageWithItsGradients) {
  const Image<std::uint8_t> image{moved(Texture{4}, 0, 0)};
  Template patch;
  EXPECT_TRUE(cut(image.view(), {9, 5}, 0, patch));
  EXPECT_FALSE(cut(image.view(), {8.9f, 5}, 0, patch));
  EXPECT_FALSE(cut(image.view(), {9, 4.9f}, 0, patch));
  EXPECT_TRUE(cut(image.view(), {width - 9, height - 6}, 0, patch));
  EXPECT_FALSE(cut(image.view(), {width - 8.9f, height - 6}, 0, patch));
  EXPECT_FALSE(cut(image.view(), {width - 9, height - 5.9f}, 0, patch));
  EXPECT_FALSE(find(image.view(), patch, 0, {-100, 20}));
  EXPECT_FALSE(find(image.view(), patch, 0, {std::nanf(""), 20}));
}

TEST(Patch, StripesFixOneAxisOnly) {
  Image<std::uint8_t> stripes{width, height};
  for (const auto [u, v] : raster(width, height)) stripes(u, v) = static_cast<std::uint8_t>(u / 4 % 2 == 0 ? 50 : 150);
  Template patch;
  ASSERT_TRUE(cut(stripes.view(), {40, 25}, 0, patch));
  EXPECT_EQ(information_v(patch), 0);
  ASSERT_TRUE(cut(moved(Texture{4}, 0, 0).view(), {40, 25}, 0, patch));
  EXPECT_GT(information_u(patch), 1);
  EXPECT_GT(information_v(patch), 1);
}

}  // namespace
}  // namespace stereogrid::test
