// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "geometry/matches.hpp"
#include "geometry/road_plane.hpp"
#include "matching/padded.hpp"
#include "matching/tops/model.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

struct Reference;

/// Short census of the images that `add_tops` compares, the right one as `ShortCensus` has it.
struct TopImages {
  const Padded<std::uint8_t>& left;
  const Padded<std::uint8_t>& right_reversed;
};

/// Costs of the disparities at the points of a row, and the cheapest disparities, or 0 where all exceed the limit.
struct TopRowCosts {
  const std::uint8_t* costs;
  std::ptrdiff_t pitch;  ///< bytes from a point's costs to the next one's
  const std::uint8_t* best;
};

/// Tops of the rows begin … end − 1 of the lattice. `costs_of_row(v)`: those of the points whose first row is v.
void find_top_rows(int begin, int end, const RoadPlane& plane, const TopRules& rules, const Matches& matches,
                   Image<ThinTop>& points, const std::function<TopRowCosts(int)>& costs_of_row);
/// Replaces the matches of those rows.
void put_top_rows(int begin, int end, const Image<ThinTop>& points, Matches& matches);

/// Replaces matches by thin tops. `tops`: the lattice, working memory.
void add_tops(Reference& reference, const TopImages& images, const RoadPlane& plane, const TopRules& rules,
              Image<ThinTop>& tops, Matches& matches);

/// Costs of the points whose first row is v. They lie in `memory`: that of `correlate_band` is large enough, whose
/// columns are four times as many.
TopRowCosts top_costs(const TopImages& images, int v, const TopRules& rules, std::uint8_t* memory);

}  // namespace stereogrid
