// SPDX-License-Identifier: Apache-2.0
//
// Comparison of neighbouring sectors' walks: passages between edges, confirmed edges, cells beside hidden ones.
#include "ground/frame_validator.hpp"
#include "images/patch.hpp"
#include "support.hpp"
#include "terrain/walk.hpp"

namespace stereogrid::test {
namespace {

/// Walks of 61 sectors of a car's camera. Edges in ring 8.
class SettledWalks : public testing::Test {
 protected:
  static constexpr int sectors{61};
  static constexpr int middle{30};
  static constexpr int edge{8};

  SettledWalks() { rings_.place(camera_, 2.4f); }

  // A passage of `width` sectors around the middle between edges of `marked` sectors to both sides.
  void set_passage(int width, int marked) {
    walks_.fill({});
    const int first{middle - width / 2};
    for (int i{0}; i < marked; ++i) walks_(first - 1 - i, 0).end = walks_(first + width + i, 0).end = edge;
  }

  int passage_end(int sector) {
    compare_walks(input(), sector, ground_.data(), walks_.view());
    const SectorWalk& walk{walks_(sector, 0)};
    if (walk.passage_end != no_ring) {
      EXPECT_EQ(walks_(walk.passage_edge, 0).end, walk.passage_end);
    }
    return walk.passage_end;
  }

  // Ground in all rings of the compared sector, lower by `fall_m` behind the edge.
  void set_ground(float fall_m) {
    for (int ring{0}; ring < rings_.count(); ++ring)
      ground_[static_cast<std::size_t>(ring)] = {ring < edge ? 0 : -fall_m, 0, TerrainClass::drivable};
  }

  [[nodiscard]] WalkInput input() const {
    return {camera_, limits_, rings_, samples_, sigma_px_.data(), rings_.count(), 9};
  }

  // Largest number of sectors that are narrower than a quarter of the vehicle's height.
  [[nodiscard]] int narrow() const {
    return static_cast<int>(0.25f * limits_.height_m * camera_.focal_px / (sector_px * rings_.middle_m(edge)));
  }

  Rig rig_{640, 360, 425, 320, 180, 0.2, 1.0, 0, 0};
  TerrainCamera camera_{rig_, [] {
                          Ground ground;
                          ground.height_m = 1;
                          return ground;
                        }()};
  TerrainLimits limits_{0.15f, 0.364f, 1.8f, 0.25f, 0.105f};
  Rings rings_{0.2f, 20, 64};
  TerrainSamples samples_{640, 360, rings_.capacity()};
  std::vector<float> sigma_px_ = std::vector<float>(static_cast<std::size_t>(rings_.capacity()), 0.3f);
  std::vector<PolarCell> ground_{static_cast<std::size_t>(rings_.capacity())};
  Image<SectorWalk> walks_{sectors, 1};
};

TEST_F(SettledWalks, PassagesEndWhereTheyAreNarrowerThanAQuarterOfTheVehiclesHeight) {
  ASSERT_GE(narrow(), 5);
  set_passage(narrow(), 5);
  EXPECT_EQ(passage_end(middle), edge);
  set_passage(narrow() + 1, 5);
  EXPECT_EQ(passage_end(middle), no_ring);
}

TEST_F(SettledWalks, PassagesNeedThreeSectorsOfTheSameEdgeBesideOneOfTheirs) {
  set_passage(5, 4);
  EXPECT_EQ(passage_end(middle), edge);
  set_passage(5, 3);
  EXPECT_EQ(passage_end(middle), no_ring);
  set_passage(5, 4);
  for (const int side : {-1, 1}) {
    EXPECT_EQ(passage_end(middle), edge);
    walks_(middle + 4 * side, 0).end = edge + 5;  // another edge than the one beside it
  }
  EXPECT_EQ(passage_end(middle), no_ring);
}

TEST_F(SettledWalks, PassagesAtTheBorderEndWhereTheyAreNarrowerThanHalfOfTheVehiclesHeight) {
  const int widest{2 * narrow() + 1};
  for (const int columns : {widest - 1, widest + 2}) {
    walks_.fill({});
    for (int sector{columns}; sector < columns + 4; ++sector) walks_(sector, 0).end = edge;
    EXPECT_EQ(passage_end(0), columns < widest ? edge : no_ring) << columns;
  }
}

TEST_F(SettledWalks, ColumnsThatTheRightCameraDoesNotSeeDoNotWidenAPassageAtTheBorder) {
  const int unseen{static_cast<int>(camera_.focal_baseline_pxm / rings_.middle_m(edge)) / sector_px};
  const int widest{2 * narrow() + 1};
  ASSERT_GE(unseen, 2);
  for (const int columns : {widest + unseen - 1, widest + unseen + 2}) {
    walks_.fill({});
    for (int sector{columns}; sector < columns + 4; ++sector) walks_(sector, 0).end = edge;
    EXPECT_EQ(passage_end(unseen), columns < widest + unseen ? edge : no_ring) << columns;
  }
}

TEST_F(SettledWalks, WiderPassagesEndWhereTheirGroundFallsAsBehindTheEdges) {
  const int widest{static_cast<int>(3.2f * static_cast<float>(narrow()))};
  for (const float fall_m : {0.0f, 0.1f, 0.3f}) {
    for (const int width : {narrow() + 1, widest, widest + 3}) {
      set_passage(width, 5);
      for (int sector{0}; sector < sectors; ++sector) walks_(sector, 0).end_fall_m = 0.3f;
      set_ground(fall_m);
      EXPECT_EQ(passage_end(middle), fall_m > 0.2f && width <= widest ? edge : no_ring) << fall_m << ' ' << width;
    }
  }
}

TEST_F(SettledWalks, APassageEndsAtItsEdgeThoughItsGroundIsThatOfNeighbours) {
  Image<float> road{640, 360};
  for (int v{181}; v < 360; ++v) std::fill_n(road.row(v), 640, static_cast<float>(v - 180) * 0.2f);
  const Image<float> none{640, 360};
  samples_.begin(camera_, limits_);
  samples_.read(0, samples_.sectors(), none.view(), road.view());
  for (int sector{0}; sector < samples_.sectors(); ++sector) samples_.place(sector, rings_);
  Image<PolarCell> cells{rings_.count(), sectors};
  for (int sector{0}; sector < sectors; ++sector) walk_sector(input(), sector, {}, cells.view(), walks_(sector, 0));
  ASSERT_TRUE(cells(edge + 1, middle).is_ground());
  std::fill_n(cells.row(middle) + 2, rings_.count() - 2, PolarCell{});
  walks_(middle, 0).lost = 2;
  walks_(middle, 0).state.is_alive = false;
  walks_(middle, 0).passage_end = edge;
  walks_(middle, 0).passage_edge = 0;
  walks_(0, 0).end_kind = GapKind::drop;
  walks_(0, 0).end_fall_m = 0.3f;
  spread_ground(input(), cells.view(), walks_.view());
  EXPECT_TRUE(cells(edge, middle).is_ground());
  EXPECT_EQ(cells(edge + 1, middle).kind, TerrainClass::hidden);
  EXPECT_EQ(walks_(middle, 0).end_kind, GapKind::drop);
  EXPECT_EQ(walks_(middle, 0).end_fall_m, 0.3f);
}

TEST_F(SettledWalks, SectorsWithTheSameEdgeAreNoPassage) {
  set_passage(5, 4);
  walks_(middle, 0).end = edge + 2;
  EXPECT_EQ(passage_end(middle), no_ring);
  walks_(middle, 0).end = edge + 5;
  EXPECT_EQ(passage_end(middle), edge);
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
  spread_hidden(4, cells.view());
  for (int sector{0}; sector < sectors; ++sector) {
    const int offset{std::abs(sector - middle)};
    const TerrainClass expected{offset == 0 ? TerrainClass::drop
                                            : (offset <= 8 ? TerrainClass::hidden : TerrainClass::unknown)};
    EXPECT_EQ(cells(1, sector).kind, expected) << sector;
    EXPECT_EQ(cells(2, sector).kind, TerrainClass::unknown) << sector;
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
    for (int v{0}; v < rig.height_px; ++v) {
      for (int u{0}; u < rig.width_px; ++u) {
        const double expected{road.disparity(u, v)};
        if (expected < 1) continue;
        const double y_m{(rig.cx_px - u) * rig.baseline_m / expected};
        const bool falls{rig.focal_px * rig.baseline_m / expected > 4 && y_m > right_m && y_m < left_m};
        matches.road(u, v) = static_cast<float>(falls ? expected / 2 : expected);
      }
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
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px / 2; ++u) {
      left(u, v) = u / 3 % 2 == 0 ? 60 : 140;
      matches.road(u, v) = 10;
    }
  }
  const MatchedFrame frame{left.view(), left.view(), matches};
  EXPECT_EQ(share_of_texture_matched(frame, 0, plane_of(1.0), 128), 1);
  matches.road.fill(0);
  EXPECT_EQ(share_of_texture_matched(frame, 0, plane_of(1.0), 128), 0);
}

}  // namespace
}  // namespace stereogrid::test
