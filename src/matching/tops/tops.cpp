// SPDX-License-Identifier: Apache-2.0
#include "matching/tops/tops.hpp"

#include <algorithm>
#include <bit>

namespace stereogrid {
namespace {

// The road is linear along a row: without road at both ends there is none.
bool has_road(const RoadPlane& plane, int v, int width) {
  const auto row = road_row(plane, v);
  return single_numbers::road_counts(row.at(0)) || single_numbers::road_counts(row.at(width - 1));
}

}  // namespace

void find_top_rows(int begin, int end, const RoadPlane& plane, const TopRules& rules, const Matches& matches,
                   Image<ThinTop>& points, const std::function<TopRowCosts(int)>& costs_of_row) {
  const std::size_t pitch{TopsWorkspace::pitch(rules.disparities)};
  const int height{matches.road.height()};
  for (int pair{begin}; pair < end; ++pair) {
    const int v{pair * top_window_rows};
    if (!has_road(plane, v, matches.road.width())) {
      std::fill_n(points.row(pair), points.width(), ThinTop{});
      continue;
    }
    const TopRowCosts found{costs_of_row(v)};
    for (int point{0}; point < points.width(); ++point) {
      const int u{top_pixel(point, points.width())};
      const auto nearest = [&](int row) {
        const int within{std::clamp(row, 0, height - 1)};
        return std::max(matches.obstacle(u, within), matches.road(u, within));
      };
      points(point, pair) =
          top_of(found.costs + static_cast<std::size_t>(point) * pitch, found.best[point], rules, plane, u, v, nearest);
    }
  }
}

void put_top_rows(int begin, int end, const Image<ThinTop>& points, Matches& matches) {
  for (int pair{begin}; pair < end; ++pair) {
    for (int point{0}; point < points.width(); ++point) {
      if (!is_in_top(points.row(pair), points.width(), point)) continue;
      for (int v{pair * top_window_rows}; v < (pair + 1) * top_window_rows; ++v) {
        for (int u{point * top_step_px}; u < (point + 1) * top_step_px; ++u) {
          put_top(points(point, pair), matches.obstacle(u, v), matches.road(u, v), matches.confidence(u, v));
        }
      }
    }
  }
}

TopsWorkspace::TopsWorkspace(int width, int height, int disparities, int threads)
    : points{top_columns(width), top_row_pairs(height)},
      costs(2 * static_cast<std::size_t>(threads) * static_cast<std::size_t>(top_columns(width)) * pitch(disparities)),
      best(static_cast<std::size_t>(threads) * static_cast<std::size_t>(top_columns(width))) {}

void add_tops(Reference&, const TopImages& images, const RoadPlane& plane, const TopRules& rules, TopsWorkspace& space,
              Matches& matches) {
  const int points{space.points.width()};
  if (points == 0) return;
  const int width{images.left.width()};
  const auto cost_at = [&](int point, int v, int disparity) {
    int cost{0};
    for (int i{-top_half_columns}; i <= top_half_columns; ++i) {
      const int u{top_pixel(point + i, points)};
      const int right{width - 1 - std::max(u - disparity, 0)};
      for (int row{v}; row < v + top_window_rows; ++row) {
        cost +=
            std::popcount(static_cast<std::uint8_t>(images.left.row(row)[u] ^ images.right_reversed.row(row)[right]));
      }
    }
    return static_cast<std::uint8_t>(cost);
  };
  find_top_rows(0, space.points.height(), plane, rules, matches, space.points, [&](int v) {
    for (int point{0}; point < points; ++point) {
      const auto index = static_cast<std::size_t>(point);
      std::uint8_t* costs{space.costs.data() + index * TopsWorkspace::pitch(rules.disparities)};
      for (int d{0}; d < rules.disparities; ++d) costs[d] = cost_at(point, v, d);
      space.best[index] = static_cast<std::uint8_t>(cheapest(costs, rules.disparities));
    }
    return TopRowCosts{space.costs.data(), space.best.data()};
  });
  put_top_rows(0, space.points.height(), space.points, matches);
}

}  // namespace stereogrid
