// SPDX-License-Identifier: Apache-2.0
#include "matching/tops/tops.hpp"

#include <algorithm>
#include <bit>
#include <vector>

namespace stereogrid {

void find_top_rows(int begin, int end, const RoadPlane& plane, const TopRules& rules, const Matches& matches,
                   Image<ThinTop>& points, const std::function<TopRowCosts(int)>& costs_of_row) {
  const int height{matches.road.height()};
  const int width{points.width()};
  for (int pair{begin}; pair < end; ++pair) {
    const int v{pair * top_window_rows};
    ThinTop* const tops{points.row(pair)};
    std::fill_n(tops, width, ThinTop{});
    const TopRoad road{plane, v};
    // it is linear along a row
    const auto [least, most] = std::minmax({road.here.at(0), road.here.at(matches.road.width() - 1)});
    const int lowest{(least >> 16) + top_over_road_px};
    if (!single_numbers::road_counts(most) || lowest + 1 >= rules.disparities) continue;
    const TopRowCosts found{costs_of_row(v)};
    for (int point{0}; point < width; ++point) {
      if (found.best[point] < lowest) continue;  // most show the road
      const int u{top_pixel(point, width)};
      const auto nearest = [&](int row) {
        const int within{std::clamp(row, 0, height - 1)};
        return std::max(matches.obstacle(u, within), matches.road(u, within));
      };
      tops[point] = top_of(found.costs + point * found.pitch, found.best[point], rules, road, u, v, nearest);
    }
  }
}

void put_top_rows(int begin, int end, const Image<ThinTop>& points, Matches& matches) {
  const int width{points.width()};
  for (int pair{begin}; pair < end; ++pair) {
    const ThinTop* row{points.row(pair)};
    if (std::none_of(row, row + width, [](const ThinTop& top) { return top.disparity > 0; })) continue;
    for (int point{0}; point < width; ++point) {
      if (!is_in_top(row, width, point)) continue;
      for (int v{pair * top_window_rows}; v < (pair + 1) * top_window_rows; ++v) {
        for (int u{point * top_step_px}; u < (point + 1) * top_step_px; ++u) {
          put_top(row[point], matches.obstacle(u, v), matches.road(u, v), matches.confidence(u, v));
        }
      }
    }
  }
}

void add_tops(Reference&, const TopImages& images, const RoadPlane& plane, const TopRules& rules, Image<ThinTop>& tops,
              Matches& matches) {
  const int points{tops.width()};
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
  std::vector<std::uint8_t> costs(static_cast<std::size_t>(points * rules.disparities));
  std::vector<std::uint8_t> best(static_cast<std::size_t>(points));
  find_top_rows(0, tops.height(), plane, rules, matches, tops, [&](int v) {
    for (int point{0}; point < points; ++point) {
      std::uint8_t* of_point{costs.data() + point * rules.disparities};
      for (int d{0}; d < rules.disparities; ++d) of_point[d] = cost_at(point, v, d);
      best[static_cast<std::size_t>(point)] = static_cast<std::uint8_t>(cheapest(of_point, rules.disparities));
    }
    return TopRowCosts{costs.data(), rules.disparities, best.data()};
  });
  put_top_rows(0, tops.height(), tops, matches);
}

}  // namespace stereogrid
