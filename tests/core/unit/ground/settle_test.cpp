// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Comparison of neighbouring sectors' walks: passages between edges, confirmed edges, cells beside hidden ones.
#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

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
    compare_walks({camera_, limits_, rings_, samples_, nullptr, rings_.count(), 9}, sector, walks_.view());
    return walks_(sector, 0).passage_end;
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
  TerrainLimits limits_{0.15f, 0.364f, 1.8f, 0.105f};
  Rings rings_{0.2f, 20, 64};
  TerrainSamples samples_{640, 360, rings_.capacity()};
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

}  // namespace
}  // namespace stereogrid::test
