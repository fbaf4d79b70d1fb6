// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/terrain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace stereogrid::evaluation {
namespace {

constexpr float free_below{0.45F};
constexpr float occupied_above{0.55F};
constexpr int step_ranges{4};
constexpr double found_share{0.9};
constexpr std::int32_t object_pixels_min{20};
constexpr double rounding_m{1e-6};

/// Cells within a distance of each other's centres.
std::vector<CellIndex> disc(double radius_m, double cell_size_m) {
  std::vector<CellIndex> offsets;
  const int reach{static_cast<int>(radius_m / cell_size_m + 1)};
  for (int y{-reach}; y <= reach; ++y) {
    for (int x{-reach}; x <= reach; ++x) {
      if (std::hypot(x, y) * cell_size_m <= radius_m) offsets.push_back({x, y});
    }
  }
  return offsets;
}

}  // namespace

TerrainScale terrain_scale(double cell_size_m) {
  if (cell_size_m < 0.1) return {{{{0, 2}, {2, 4}}}, 0.1};
  return {{{{0, 8}, {8, 13}}}, 0.4};
}

/// One frame's grid beside its truth, by the truth's cells.
class TerrainScores::Frame {
 public:
  Frame(View<const float> probability, CellShift shift, const FrameTruth& truth, const TruthGrid& truth_grid)
      : probability_{probability},
        shift_{shift},
        truth_{truth},
        geometry_{truth_grid.geometry},
        scale_{terrain_scale(geometry_.cell_size_m)},
        within_{disc(scale_.tolerance_m + rounding_m, geometry_.cell_size_m)},
        nearer_{disc(scale_.tolerance_m - rounding_m, geometry_.cell_size_m)} {}

  [[nodiscard]] TerrainCell at(CellIndex cell) const {
    return static_cast<TerrainCell>(truth_.terrain(cell.ix, cell.iy));
  }
  [[nodiscard]] bool is_free(CellIndex cell) const { return probability_of(cell) < free_below; }
  [[nodiscard]] bool is_occupied(CellIndex cell) const { return probability_of(cell) > occupied_above; }
  [[nodiscard]] double range_m(CellIndex cell) const { return geometry_.centre(cell.ix, cell.iy).x; }
  [[nodiscard]] bool is_object(CellIndex cell) const { return truth_.pixels(cell.ix, cell.iy) > 0; }
  [[nodiscard]] double step_m(CellIndex cell) const { return static_cast<double>(truth_.step_m(cell.ix, cell.iy)); }
  /// True if a cell within the tolerance is occupied.
  [[nodiscard]] bool is_found(CellIndex cell) const {
    return any(within_, cell, [this](CellIndex other) { return is_occupied(other); });
  }
  [[nodiscard]] bool is_at_an_edge(CellIndex cell) const {
    return any(within_, cell, [this](CellIndex other) { return at(other) == TerrainCell::drop; });
  }
  /// True if a cell beyond an edge is farther from it than the tolerance.
  [[nodiscard]] bool is_deep(CellIndex cell) const {
    return !any(nearer_, cell, [this](CellIndex other) {
      return at(other) == TerrainCell::drop || at(other) == TerrainCell::drivable;
    });
  }
  [[nodiscard]] bool is_in_grid(CellIndex cell) const {
    const int ix{cell.ix + shift_.x};
    const int iy{cell.iy + shift_.y};
    return ix >= 0 && iy >= 0 && ix < probability_.width && iy < probability_.height;
  }

  void add_cell(CellIndex cell, TerrainCounts& counts) const;
  void add_objects(std::array<TerrainCounts, 2>& ranges) const;
  void add_to_zones(CellIndex cell, std::vector<ZoneScore>& zones) const;

 private:
  [[nodiscard]] float probability_of(CellIndex cell) const {
    return is_in_grid(cell) ? probability_(cell.ix + shift_.x, cell.iy + shift_.y) : 0.5F;
  }
  template <class Test>
  bool any(const std::vector<CellIndex>& offsets, CellIndex cell, Test test) const {
    return std::ranges::any_of(offsets, [&](CellIndex offset) {
      const CellIndex other{cell.ix + offset.ix, cell.iy + offset.iy};
      return other.ix >= 0 && other.iy >= 0 && other.ix < geometry_.nx && other.iy < geometry_.ny && test(other);
    });
  }

  View<const float> probability_;
  CellShift shift_;
  const FrameTruth& truth_;
  GridGeometry geometry_;
  TerrainScale scale_;
  std::vector<CellIndex> within_;
  std::vector<CellIndex> nearer_;
};

void TerrainScores::Frame::add_cell(CellIndex cell, TerrainCounts& counts) const {
  switch (at(cell)) {
    case TerrainCell::drivable:
      if (is_at_an_edge(cell)) return;
      ++counts.drivable;
      counts.drivable_free += is_free(cell) ? 1 : 0;
      counts.drivable_occupied += is_occupied(cell) ? 1 : 0;
      return;
    case TerrainCell::drop:
      ++counts.edges;
      counts.edges_found += is_found(cell) ? 1 : 0;
      return;
    case TerrainCell::obstacle:
      if (!is_object(cell)) {
        ++counts.rises;
        counts.rises_found += is_found(cell) ? 1 : 0;
      }
      ++counts.deadly;
      counts.deadly_free += is_free(cell) && !is_found(cell) ? 1 : 0;
      return;
    case TerrainCell::beyond:
      if (!is_deep(cell)) return;
      ++counts.deadly;
      counts.deadly_free += is_free(cell) ? 1 : 0;
      return;
    default:
      return;
  }
}

/// An object counts in the range of its nearest cell.
void TerrainScores::Frame::add_objects(std::array<TerrainCounts, 2>& ranges) const {
  struct Seen {
    double range_m{std::numeric_limits<double>::infinity()};
    std::int32_t pixels{0};
    bool is_found{false};
  };
  std::map<std::int32_t, Seen> objects;
  for (int iy{0}; iy < geometry_.ny; ++iy) {
    for (int ix{0}; ix < geometry_.nx; ++ix) {
      if (!is_object({ix, iy}) || !is_in_grid({ix, iy})) continue;
      Seen& seen{objects[truth_.seen_object(ix, iy)]};
      seen.range_m = std::min(seen.range_m, range_m({ix, iy}));
      seen.pixels += truth_.pixels(ix, iy);
      seen.is_found = seen.is_found || is_found({ix, iy});
    }
  }
  for (const auto& [id, seen] : objects) {
    for (std::size_t i{0}; i < ranges.size(); ++i) {
      const Band range{scale_.ranges[i]};
      if (seen.pixels < object_pixels_min || seen.range_m < range.from_m || seen.range_m >= range.to_m) continue;
      ++ranges[i].objects;
      ranges[i].objects_found += seen.is_found ? 1 : 0;
    }
  }
}

void TerrainScores::Frame::add_to_zones(CellIndex cell, std::vector<ZoneScore>& zones) const {
  const Point2 at_m{truth_.ego.world_from_vehicle * geometry_.centre(cell.ix, cell.iy)};
  const auto score = std::ranges::find_if(zones, [at_m](const ZoneScore& candidate) {
    const TruthZone& zone{candidate.zone};
    return at_m.x >= zone.low.x && at_m.x < zone.high.x && at_m.y >= zone.low.y && at_m.y < zone.high.y;
  });
  if (score == zones.end()) return;
  TerrainCounts counts;
  add_cell(cell, counts);
  const bool is_mark{at(cell) == TerrainCell::obstacle || at(cell) == TerrainCell::drop};
  score->marks += is_mark ? 1 : 0;
  score->marks_found += is_mark && is_found(cell) ? 1 : 0;
  score->deadly += counts.deadly;
  score->deadly_free += counts.deadly_free;
  score->drivable += counts.drivable;
  score->drivable_occupied += counts.drivable_occupied;
}

void TerrainScores::add_cell(const Frame& frame, CellIndex cell) {
  const double range_m{frame.range_m(cell)};
  const double far_m{summary_.scale.ranges.back().to_m};
  const bool is_near{range_m < summary_.scale.ranges.front().to_m};
  if (range_m >= far_m || !frame.is_in_grid(cell)) return;
  frame.add_cell(cell, summary_.ranges[is_near ? 0 : 1]);
  if (is_near) frame.add_to_zones(cell, summary_.zones);
  const double step_m{frame.step_m(cell)};
  if (step_m == 0 || frame.is_object(cell)) return;
  Found& found{steps_[{static_cast<int>(step_ranges * range_m / far_m), static_cast<int>(std::lround(100 * step_m))}]};
  ++found.cells;
  found.found += frame.is_found(cell) ? 1 : 0;
}

void TerrainScores::add(View<const float> probability, const GridGeometry& grid, const FrameTruth& truth,
                        const TruthGrid& truth_grid) {
  if (truth.terrain.empty()) return;
  const GridGeometry& cells{truth_grid.geometry};
  const Frame frame{probability, shift_between(grid, cells), truth, truth_grid};
  summary_.scale = terrain_scale(cells.cell_size_m);
  ++summary_.frames;
  if (summary_.zones.empty()) {
    for (const TruthZone& zone : truth_grid.zones) summary_.zones.push_back({zone});
  }
  for (int iy{0}; iy < cells.ny; ++iy) {
    for (int ix{0}; ix < cells.nx; ++ix) add_cell(frame, {ix, iy});
  }
  frame.add_objects(summary_.ranges);
}

void WitnessScores::add(View<const float> probability, View<const CellWitness> witness, const Labels& labels) {
  if (witness.width == 0) return;
  const auto is_found = [&](int x, int y) {
    for (int iy{std::max(y - 1, 0)}; iy <= std::min(y + 1, probability.height - 1); ++iy) {
      for (int ix{std::max(x - 1, 0)}; ix <= std::min(x + 1, probability.width - 1); ++ix)
        if (probability(ix, iy) > 0.5F) return true;
    }
    return false;
  };
  std::size_t wrong{0};
  const auto count = [&](int ix, int iy, std::size_t& cells, std::size_t& occupied) {
    ++cells;
    if (labels.cells(ix, iy) != labelled_occupied || is_found(ix, iy)) return;
    ++occupied;
    ++wrong;
  };
  for (int iy{0}; iy < probability.height; ++iy) {
    for (int ix{0}; ix < probability.width; ++ix) {
      if (!(probability(ix, iy) < 0.5F) || labels.cells(ix, iy) == not_scored) continue;
      const Witness kind{witness(ix, iy).kind()};
      if (kind == Witness::ground) count(ix, iy, summary_.ground, summary_.ground_occupied);
      if (kind == Witness::memory) count(ix, iy, summary_.memory, summary_.memory_occupied);
      if (kind == Witness::source) count(ix, iy, summary_.source, summary_.source_occupied);
    }
  }
  ++summary_.frames;
  summary_.failed += wrong > 0 ? 1 : 0;
}

WitnessSummary WitnessScores::summary() const {
  WitnessSummary summary{summary_};
  if (summary.failed == 0) summary.failed_at_most = std::min(3 / static_cast<double>(summary.frames), 1.0);
  return summary;
}

TerrainSummary TerrainScores::summary() const {
  TerrainSummary summary{summary_};
  std::erase_if(summary.zones, [](const ZoneScore& zone) { return zone.marks + zone.drivable == 0; });
  const double width_m{summary.scale.ranges.back().to_m / step_ranges};
  for (int i{0}; i < step_ranges; ++i) {
    SmallestStep smallest{{i * width_m, (i + 1) * width_m}};
    const auto first = steps_.lower_bound({i, std::numeric_limits<int>::min()});
    const auto last = steps_.lower_bound({i + 1, std::numeric_limits<int>::min()});
    if (std::distance(first, last) < 2) continue;
    const auto is_enough = [](const Found& found) {
      return static_cast<double>(found.found) >= found_share * static_cast<double>(found.cells);
    };
    for (auto step = first; step != last && step->first.second < 0 && is_enough(step->second); ++step) {
      smallest.down_m = -step->first.second / 100.0;
    }
    for (auto step = last; step != first;) {
      --step;
      if (step->first.second < 0 || !is_enough(step->second)) break;
      smallest.up_m = step->first.second / 100.0;
    }
    summary.steps.push_back(smallest);
  }
  return summary;
}

}  // namespace stereogrid::evaluation
