// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "support.hpp"

namespace stereogrid {
namespace {

using test::small_kitti_rig;
using test::Texture;

constexpr double obstacle_px{12.3};
constexpr int road_begins{100};

using Terms = RowTerms;
constexpr Terms like_kitti{-0.25, 0.1, 0.05, 0.5, -0.15};

RowOffsets offsets_of(const Terms& terms) {
  const Rig rig{small_kitti_rig()};
  return {terms, rig.cx_px, rig.cy_px};
}

/// A wall above a road, the rows of the right image off by `terms`; and its true disparities.
struct Pair {
  explicit Pair(const Terms& terms, unsigned seed = 1)
      : matches{rig.width_px, rig.height_px}, left{rig.width_px, rig.height_px}, right{rig.width_px, rig.height_px} {
    const Texture texture{seed};
    const RowOffsets offsets{offsets_of(terms)};
    for (const auto [u, v] : raster(rig.width_px, rig.height_px)) {
      (v < road_begins ? matches.obstacle : matches.road)(u, v) = static_cast<float>(disparity(v));
      left(u, v) = grey(texture.at(u, v));
      // the row of the left image that is seen here
      const double row{v - offsets.at(u, v - offsets.at(u, v))};
      right(u, v) = grey(texture.at(u + disparity(row), row));
    }
  }

  [[nodiscard]] double disparity(double v) const {
    return v < road_begins ? obstacle_px : obstacle_px + plane.per_v * (v - road_begins);
  }
  static std::uint8_t grey(double level) { return static_cast<std::uint8_t>(level + 0.5); }
  bool update(RowAlignment& alignment) const { return alignment.update(left.view(), right.view(), matches, plane); }

  Rig rig{small_kitti_rig()};
  RoadPlane plane{-1000, 0, 0.2, 0, 0};
  Matches matches;
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

double largest_error(const RowOffsets& offsets, const Terms& terms) {
  const RowOffsets wanted{offsets_of(terms)};
  const Rig rig{small_kitti_rig()};
  double most{0};
  for (int v{0}; v < rig.height_px; v += 20) {
    for (int u{0}; u < rig.width_px; u += 20) most = std::max(most, std::abs(offsets.at(u, v) - wanted.at(u, v)));
  }
  return most;
}

TEST(Alignment, RowsAreWhereTheOffsetsSay) {
  const RowOffsets offsets{offsets_of({0.5, 0, 0, 0})};
  Image<std::uint8_t> right{40, 30};
  for (int v{0}; v < 30; ++v) std::fill(right.row(v), right.row(v) + 40, static_cast<std::uint8_t>(4 * v));
  Image<std::uint8_t> aligned{40, 30};
  Cpu cpu{1};
  align_rows(cpu, right.view(), offsets, aligned.view());
  EXPECT_EQ(aligned(3, 7), 4 * 7 + 2);
  EXPECT_EQ(aligned(35, 20), 4 * 20 + 2);
  EXPECT_EQ(aligned(35, 29), 4 * 29) << "below the image the last row is repeated";
}

TEST(Alignment, CpuEqualsReference) {
  std::mt19937 generator{5};
  for (int round{0}; round < 20; ++round) {
    const int width{test::uniform_int(generator, 1, 150)};
    const int height{test::uniform_int(generator, 1, 60)};
    const Image<std::uint8_t> right{test::noise_image(width, height, generator)};
    RowOffsets offsets;
    const double reach{round < 15 ? 2.0 : 1000.0};
    for (double& term : offsets.terms) term = test::uniform(generator, -reach, reach);
    Image<std::uint8_t> wanted{width, height};
    Reference reference;
    align_rows(reference, right.view(), offsets, wanted.view());
    for (const int threads : {1, 2}) {
      Image<std::uint8_t> aligned{width, height};
      Cpu cpu{threads};
      align_rows(cpu, right.view(), offsets, aligned.view());
      EXPECT_EQ(test::count_differences(aligned, wanted), 0) << width << " x " << height;
    }
  }
}

TEST(Alignment, NoOffsetChangesNothing) {
  std::mt19937 generator{6};
  const Image<std::uint8_t> right{test::noise_image(101, 33, generator)};
  Image<std::uint8_t> aligned{101, 33};
  Cpu cpu{2};
  align_rows(cpu, right.view(), {}, aligned.view());
  EXPECT_EQ(aligned, right);
}

TEST(Alignment, PlacesFollowTheFormula) {
  const RowOffsets offsets{offsets_of({-0.7, 0.3, 0.2, -0.4, 0.3})};
  for (const int v : {0, 93, 187}) {
    for (const int u : {0, 311, 620}) {
      EXPECT_NEAR(place_256(offsets, u, v) / 256.0, v + offsets.at(u, v), 0.04);
    }
  }
}

TEST(Alignment, PlacesAreRoundedToTheNearest256thOfARow) {
  EXPECT_EQ(place_256(offsets_of({0.3, 0, 0, 0, 0}), 100, 50), 50 * 256 + 77);
  EXPECT_EQ(place_256(offsets_of({-0.3, 0, 0, 0, 0}), 100, 50), 50 * 256 - 77);
}

TEST(Alignment, FindsARowErrorInOneFrame) {
  for (const Terms& terms :
       {like_kitti, Terms{0.6, 0, 0, 0}, Terms{0, -0.4, 0, 0}, Terms{-0.1, 0, 0.5, -0.3, 0}, Terms{0, 0, 0, 0, 0.5}}) {
    RowAlignment alignment{small_kitti_rig()};
    ASSERT_TRUE(Pair{terms}.update(alignment));
    EXPECT_FALSE(alignment.is_identity());
    EXPECT_LT(largest_error(alignment.offsets(), terms), 0.03);
  }
}

TEST(Alignment, AlignedPairsStayAlone) {
  RowAlignment alignment{small_kitti_rig()};
  for (unsigned seed{1}; seed < 6; ++seed) {
    EXPECT_TRUE(Pair({}, seed).update(alignment));
    EXPECT_TRUE(alignment.is_identity());
    EXPECT_LT(largest_error(alignment.offsets(), {}), 0.03);
  }
}

TEST(Alignment, WrongDisparitiesAreOutvoted) {
  Pair pair{like_kitti};
  for (int v{0}; v < pair.rig.height_px; ++v) {
    for (int u{0}; u < pair.rig.width_px; u += 2) pair.matches.obstacle(u / 3, v) *= 1.8f;
  }
  RowAlignment alignment{pair.rig};
  ASSERT_TRUE(pair.update(alignment));
  EXPECT_LT(largest_error(alignment.offsets(), like_kitti), 0.05);
}

TEST(Alignment, WithoutTextureOrMatchesNothingIsSaid) {
  Pair blank{like_kitti};
  blank.left.fill(90);
  blank.right.fill(90);
  Pair unmatched{like_kitti};
  unmatched.matches.road.fill(0);
  unmatched.matches.obstacle.fill(0);
  Pair few{unmatched};
  for (int u{300}; u < 340; ++u) std::fill_n(&few.matches.obstacle(u, 0), 1, 12.3f);
  Pair unlike{like_kitti};
  std::mt19937 generator{9};
  unlike.right = test::noise_image(unlike.rig.width_px, unlike.rig.height_px, generator);
  for (const Pair* pair : {&blank, &unmatched, &few, &unlike}) {
    RowAlignment alignment{pair->rig};
    EXPECT_FALSE(pair->update(alignment));
    EXPECT_TRUE(alignment.is_identity());
    EXPECT_EQ(alignment.offsets().terms, Terms{});
  }
}

TEST(Alignment, VerticalEdgesSayNothingAboutRows) {
  Pair stripes{{}};
  for (const auto [u, v] : raster(stripes.rig.width_px, stripes.rig.height_px)) {
    stripes.left(u, v) = Pair::grey(100 + 60 * std::sin(u * 0.7));
    stripes.right(u, v) = Pair::grey(100 + 60 * std::sin((u + obstacle_px) * 0.7));
  }
  stripes.matches.obstacle.fill(static_cast<float>(obstacle_px));
  stripes.matches.road.fill(0);
  RowAlignment alignment{stripes.rig};
  EXPECT_FALSE(stripes.update(alignment));
  EXPECT_TRUE(alignment.is_identity());
}

TEST(Alignment, ImplausibleOffsetsAreRejected) {
  RowAlignment alignment{small_kitti_rig()};
  ASSERT_TRUE(Pair{like_kitti}.update(alignment));
  const Terms before{alignment.offsets().terms};
  for (const Terms& terms : {Terms{3.5, 0, 0, 0}, Terms{0, 2.5, 0, 2.0}}) {
    EXPECT_FALSE(Pair{terms}.update(alignment));
    EXPECT_EQ(alignment.offsets().terms, before);
  }
}

TEST(Alignment, FollowsSlowlyAndDecays) {
  RowAlignment alignment{small_kitti_rig()};
  const Pair off{{0.4, 0, 0, 0}};
  const Pair fine{{}};
  for (int frame{0}; frame < 10; ++frame) ASSERT_TRUE(off.update(alignment));
  ASSERT_TRUE(fine.update(alignment));
  EXPECT_NEAR(alignment.offsets().terms[0], 0.34, 0.05) << "a single frame has a small say";
  for (int frame{0}; frame < 30; ++frame) ASSERT_TRUE(fine.update(alignment));
  EXPECT_TRUE(alignment.is_identity());
}

TEST(Alignment, ImagesSmallerThanAPatch) {
  Rig rig{small_kitti_rig()};
  rig.width_px = 7;
  rig.height_px = 5;
  RowAlignment alignment{rig};
  const Image<std::uint8_t> grey{7, 5, 50};
  EXPECT_FALSE(alignment.update(grey.view(), grey.view(), Matches{7, 5}, RoadPlane{}));
}

}  // namespace
}  // namespace stereogrid
