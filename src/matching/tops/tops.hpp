// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/matches.hpp"
#include "geometry/road_plane.hpp"
#include "matching/padded.hpp"
#include "matching/tops/model.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// Working memory of `add_tops`.
struct TopsWorkspace {
  TopsWorkspace() = default;
  TopsWorkspace(int width, int height, int disparities, int threads);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(points, costs, best); }

  /// Bytes of a point's costs: whole vectors.
  static std::size_t pitch(int disparities) { return (static_cast<std::size_t>(disparities) + 63) / 64 * 64; }

  Image<ThinTop> points;            ///< the lattice
  std::vector<std::uint8_t> costs;  ///< each thread's: those of the columns and of the windows of a row of points
  std::vector<std::uint8_t> best;   ///< each thread's: the cheapest disparities of a row of points
};

/// Short census of the images that `add_tops` compares, the right one as `ShortCensus` has it.
struct TopImages {
  const Padded<std::uint8_t>& left;
  const Padded<std::uint8_t>& right_reversed;
};

/// Costs of the disparities at the points of a row, `TopsWorkspace::pitch` bytes a point, and the cheapest disparities.
struct TopRowCosts {
  const std::uint8_t* costs;
  const std::uint8_t* best;
};

/// Tops of the rows begin … end − 1 of the lattice. `costs_of_row(v)`: those of the points whose first row is v.
void find_top_rows(int begin, int end, const RoadPlane& plane, const TopRules& rules, const Matches& matches,
                   Image<ThinTop>& points, const std::function<TopRowCosts(int)>& costs_of_row);
/// Replaces the matches of those rows.
void put_top_rows(int begin, int end, const Image<ThinTop>& points, Matches& matches);

/// Replaces matches by thin tops.
void add_tops(Cpu& cpu, const TopImages& images, const RoadPlane& plane, const TopRules& rules, TopsWorkspace& space,
              Matches& matches);
void add_tops(Reference& reference, const TopImages& images, const RoadPlane& plane, const TopRules& rules,
              TopsWorkspace& space, Matches& matches);

/// Costs of the disparities at the points of row pair v, `pitch` bytes a point, and the cheapest ones; 0 where all
/// exceed the limit. `columns`: as large as the costs, working memory.
void top_costs(const TopImages& images, int v, const TopRules& rules, std::uint8_t* columns, std::uint8_t* costs,
               std::uint8_t* best);

}  // namespace stereogrid
