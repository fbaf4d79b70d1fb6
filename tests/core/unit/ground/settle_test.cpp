// SPDX-License-Identifier: Apache-2.0
//
// Comparison of neighbouring sectors: ways between edges, confirmed edges, cells beside hidden ones.
#include "terrain/settle.hpp"
#include "ground/frame_validator.hpp"
#include "images/patch.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

/// Walks of 61 sectors of a car's camera. Edges in ring 8.
class SettledWalks : public testing::Test {
 protected:
  static constexpr int sectors{61};
  static constexpr int middle{30};
  static constexpr int edge{8};

  SettledWalks() { rings_.place(camera_, 2.4f); }

  // Ground, in rings edge to edge + 2 the cells of sectors first … end − 1 alone; the others have `kind`.
  void set_way(int first, int end, TerrainClass kind = TerrainClass::hidden) {
    cells_.fill({0, 0, TerrainClass::drivable});
    for (int sector{0}; sector < sectors; ++sector) {
      if (sector >= first && sector < end) continue;
      std::fill_n(cells_.row(sector) + edge, 3, PolarCell{.kind = kind});
    }
  }

  // Ground remains behind the edge, in all sectors or in none.
  bool reaches_beyond() {
    hide_unconnected(input(), cells_.view(), reached_.view());
    for (int sector{0}; sector < sectors; ++sector) {
      EXPECT_TRUE(cells_(edge - 1, sector).is_ground()) << sector;
      EXPECT_EQ(cells_(edge + 3, sector).kind, cells_(edge + 3, middle).kind) << sector;
    }
    return cells_(edge + 3, middle).is_ground();
  }

  [[nodiscard]] WalkInput input() const {
    return {camera_, limits_, rings_, nullptr, sectors, sigma_px_.data(), rings_.count(), 9};
  }

  // Number of sectors behind the edge that are as wide as the vehicle is high.
  [[nodiscard]] int wide() const {
    return static_cast<int>(std::ceil(limits_.height_m * camera_.focal_px / (sector_px * rings_.middle_m(edge))));
  }

  Rig rig_{640, 360, 425, 320, 180, 0.2, 1.0, 0, 0};
  TerrainCamera camera_{rig_, [] {
                          Ground ground;
                          ground.height_m = 1;
                          return ground;
                        }()};
  TerrainLimits limits_{0.15f, 0.364f, 1.8f, 0.25f, 0.105f};
  Rings rings_{0.2f, 20, 64};
  std::vector<float> sigma_px_ = std::vector<float>(static_cast<std::size_t>(rings_.capacity()), 0.3f);
  Image<PolarCell> cells_{rings_.capacity(), sectors};
  Image<std::uint8_t> reached_{sectors, 1};
  Image<SectorWalk> walks_{sectors, 1};
};

TEST_F(SettledWalks, GroundBehindAnEdgeNeedsAWayAsWideAsTheVehicleIsHigh) {
  ASSERT_GE(wide(), 5);
  for (const int width : {0, wide() - 1, wide()}) {
    set_way(middle, middle + width);
    EXPECT_EQ(reaches_beyond(), width == wide()) << width;
  }
}

TEST_F(SettledWalks, WaysEndAtTheImagesBorderAndWhereTheRightCameraSeesNothing) {
  const int unseen{static_cast<int>(camera_.focal_baseline_pxm / rings_.middle_m(edge)) / sector_px};
  ASSERT_GE(unseen, 2);
  for (const int more : {-1, 0}) {
    set_way(sectors - wide() - more, sectors);
    EXPECT_EQ(reaches_beyond(), more == 0) << more;
    set_way(0, unseen + wide() + more);
    EXPECT_EQ(reaches_beyond(), more == 0) << more;
  }
}

TEST_F(SettledWalks, AWayThatIsWideInEachRingMustNotJumpAcross) {
  set_way(0, middle);
  for (int sector{0}; sector < middle; ++sector) cells_(edge + 1, sector).kind = TerrainClass::drop;
  for (int sector{middle}; sector < sectors; ++sector) cells_(edge + 1, sector).kind = TerrainClass::drivable;
  EXPECT_FALSE(reaches_beyond());
}

TEST_F(SettledWalks, ObstaclesAndGroundThatIsNotSeenDoNotNarrowAWay) {
  for (const TerrainClass kind : {TerrainClass::obstacle, TerrainClass::unknown}) {
    set_way(middle, middle + 1, kind);
    EXPECT_TRUE(reaches_beyond());
  }
}

TEST_F(SettledWalks, SectorsWithoutSamplesBetweenGroundAreGroundWhereTheyAreNoWiderThanTheRingIsLong) {
  constexpr int ring{edge};
  const float length_m{rings_.end_m(ring) - rings_.begin_m(ring)};
  const int widest{static_cast<int>(length_m * camera_.focal_px / (sector_px * rings_.middle_m(ring)))};
  ASSERT_GE(widest, 2);
  const auto is_filled = [&](int width, float far_z, TerrainClass kind) {
    cells_.fill({0, 0, TerrainClass::drivable});
    for (int i{0}; i < width; ++i) cells_(ring, middle + i) = PolarCell{};
    cells_(ring, middle + 1).kind = kind;
    for (int sector{middle + width}; sector < sectors; ++sector) cells_(ring, sector).elevation_m = far_z;
    fill_streaks(input(), ring, walks_.view(), cells_.view());
    return cells_(ring, middle).is_ground();
  };
  EXPECT_TRUE(is_filled(widest, 0.1f, TerrainClass::unknown));
  EXPECT_NEAR(cells_(ring, middle + widest - 1).elevation_m,
              0.1f * static_cast<float>(widest) / static_cast<float>(widest + 1), 1e-6);
  EXPECT_FALSE(is_filled(widest + 1, 0, TerrainClass::unknown));
  EXPECT_FALSE(is_filled(widest, 1, TerrainClass::unknown)) << "a step";
  for (const TerrainClass kind : {TerrainClass::hidden, TerrainClass::drop, TerrainClass::obstacle})
    EXPECT_FALSE(is_filled(widest, 0, kind));
  walks_(middle + 1, 0).state.is_blocked = true;
  EXPECT_FALSE(is_filled(widest, 0, TerrainClass::unknown)) << "behind an obstacle";
}

TEST_F(SettledWalks, EdgesAreMarkedUpToWhereTheGapWasMetIfNeighboursConfirmThem) {
  constexpr int rings{20};
  for (const int confirmations : {3, 4}) {
    walks_.fill({});
    for (int sector{middle}; sector < middle + 4; ++sector) walks_(sector, 0).end = edge;
    SectorWalk& walk{walks_(middle, 0)};
    walk.end_seen = edge + 2;
    walk.end_kind = GapKind::drop;
    walk.end_confirmations = confirmations;
    std::vector<PolarCell> cells(rings);
    for (int ring{edge}; ring < rings; ++ring) cells[static_cast<std::size_t>(ring)].kind = TerrainClass::hidden;
    settle_sector(middle, walks_.view(), rings, cells.data());
    for (int ring{0}; ring < rings; ++ring) {
      const TerrainClass behind{confirmations > 3 ? TerrainClass::unknown
                                                  : (ring <= edge + 2 ? TerrainClass::drop : TerrainClass::hidden)};
      EXPECT_EQ(cells[static_cast<std::size_t>(ring)].kind, ring < edge ? TerrainClass::unknown : behind) << ring;
    }
  }
}

TEST_F(SettledWalks, UnknownCellsUpToEightSectorsBesideAnEdgeAreHidden) {
  Image<PolarCell> cells{4, sectors};
  cells(1, middle).kind = TerrainClass::drop;
  for (int ring{0}; ring < 4; ++ring) spread_hidden(ring, cells.view());
  for (int sector{0}; sector < sectors; ++sector) {
    const int offset{std::abs(sector - middle)};
    const TerrainClass expected{offset == 0 ? TerrainClass::drop
                                            : (offset <= 8 ? TerrainClass::hidden : TerrainClass::unknown)};
    EXPECT_EQ(cells(1, sector).kind, expected) << sector;
    EXPECT_EQ(cells(2, sector).kind, TerrainClass::unknown) << sector;
  }
}

// A slope across, however long, costs a few sectors, unless it is steeper than any ground.
TEST_F(SettledWalks, AtTheEndsOfAnEdgeGroundThatIsLowerByTwoSigmaIsHidden) {
  const float sigma_m{camera_.elevation_sigma(camera_.height_m, rings_.middle_m(edge), sigma_px_[0])};
  const auto hidden_beside = [&](int side, float fall_m, int lower) {
    cells_.fill({0, 0, TerrainClass::drivable});
    for (int i{1}; i <= lower; ++i) cells_(edge, middle + side * i).elevation_m = -fall_m;
    cells_(edge, middle).kind = TerrainClass::hidden;
    hide_ends(input(), edge, cells_.view());
    int hidden{0};
    for (int sector{0}; sector < sectors; ++sector) hidden += is_behind_edge(cells_(edge, sector)) ? 1 : 0;
    for (int i{0}; i < hidden; ++i) EXPECT_TRUE(is_behind_edge(cells_(edge, middle + side * i))) << i;
    return hidden - 1;
  };
  for (const int side : {-1, 1}) {
    EXPECT_EQ(hidden_beside(side, 2.1f * sigma_m, 2), 2);
    EXPECT_EQ(hidden_beside(side, 2.1f * sigma_m, sectors_beside), sectors_beside);
    EXPECT_EQ(hidden_beside(side, 1.9f * sigma_m, 2), 0);
    EXPECT_EQ(hidden_beside(side, 2.1f * sigma_m, middle), 0) << "level ground behind the edge's smear";
  }
  const float steep_m{input().limits.slope * sector_px * rings_.middle_m(edge) / camera_.focal_px};
  for (const float rise_m : {0.8f * sigma_m, 0.9f * steep_m, 1.1f * steep_m}) {
    cells_.fill({0, 0, TerrainClass::drivable});
    cells_(edge, middle).kind = TerrainClass::hidden;
    for (int sector{middle + 1}; sector < sectors; ++sector)
      cells_(edge, sector).elevation_m = rise_m * static_cast<float>(sector);
    hide_ends(input(), edge, cells_.view());
    EXPECT_TRUE(is_behind_edge(cells_(edge, middle + sectors_beside)));
    EXPECT_EQ(is_behind_edge(cells_(edge, middle + sectors_beside + 1)), rise_m > steep_m) << rise_m;
  }
}

const Rig rig{640, 360, 425, 320, 140, 0.2, 1.0, 0, 0};

RoadPlane plane_of(double height_m, double roll_rad = 0) {
  Ground ground;
  ground.height_m = height_m;
  ground.roll_rad = roll_rad;
  return road_plane(rig, ground);
}

TEST(Matrix3, IsPositiveDefiniteIfAllPivotsAreAboveRounding) {
  EXPECT_TRUE(is_positive_definite(diagonal({{1, 2, 3}})));
  Matrix3 matrix{diagonal({{1, 1, 1}})};
  matrix[0][2] = matrix[2][0] = matrix[1][2] = matrix[2][1] = 0.6;
  EXPECT_TRUE(is_positive_definite(matrix));
  matrix[0][2] = matrix[2][0] = matrix[1][2] = matrix[2][1] = 0.9;
  EXPECT_FALSE(is_positive_definite(matrix));
  matrix[0][2] = matrix[2][0] = 0;
  matrix[1][2] = matrix[2][1] = 1 - 1e-12;
  EXPECT_FALSE(is_positive_definite(matrix));
}

TEST(Matrix3, SumsOfVectors) {
  const Vector3 sum{Vector3{{1, 2, 3}} + Vector3{{10, 20, 30}}};
  for (int i{0}; i < 3; ++i) EXPECT_EQ(sum[i], 11 * (i + 1));
}

// Matches of a road that falls away from some distance on, between two lines along the road.
struct FallingRoad {
  FallingRoad(double right_m, double left_m) {
    for (const auto [u, v] : raster(rig.width_px, rig.height_px)) {
      const double expected{road.disparity(u, v)};
      if (expected < 1) continue;
      const double y_m{(rig.cx_px - u) * rig.baseline_m / expected};
      const bool falls{rig.focal_px * rig.baseline_m / expected > 4 && y_m > right_m && y_m < left_m};
      matches.road(u, v) = static_cast<float>(falls ? expected / 2 : expected);
    }
  }
  [[nodiscard]] double width_m() const { return width_falling_away({left.view(), left.view(), matches}, rig, road); }

  RoadPlane road{plane_of(1.0)};
  Image<std::uint8_t> left{rig.width_px, rig.height_px};
  Matches matches{rig.width_px, rig.height_px};
};

// The width is that at the third sample of a column, up to 1.4 times as far as the first.
TEST(FallingAway, IsGroundWithinAMetreOfTheVehiclesPath) {
  EXPECT_EQ(FallingRoad(0, 0).width_m(), 0);
  EXPECT_NEAR(FallingRoad(-0.5, 0.5).width_m(), 1.2, 0.2);
  EXPECT_NEAR(FallingRoad(-0.5, 3).width_m(), 1.8, 0.3);
  EXPECT_EQ(FallingRoad(1.2, 3).width_m(), 0);
}

TEST(TextureMatched, CountsPixelsWithTexture) {
  Image<std::uint8_t> left{rig.width_px, rig.height_px, 100};
  Matches matches{rig.width_px, rig.height_px};
  // stripes on the left half
  for (const auto [u, v] : raster(rig.width_px / 2, rig.height_px)) {
    left(u, v) = u / 3 % 2 == 0 ? 60 : 140;
    matches.road(u, v) = 10;
  }
  const MatchedFrame frame{left.view(), left.view(), matches};
  EXPECT_EQ(share_of_texture_matched(frame, 0, plane_of(1.0), 128), 1);
  matches.road.fill(0);
  EXPECT_EQ(share_of_texture_matched(frame, 0, plane_of(1.0), 128), 0);
}

}  // namespace
}  // namespace stereogrid::test
