// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "matching/tops/tops.hpp"

namespace stereogrid {

void add_tops(Cpu& cpu, const TopImages& images, const RoadPlane& plane, const TopRules& rules, TopsWorkspace& space,
              Matches& matches) {
  if (space.points.width() == 0) return;
  const std::size_t of_row{static_cast<std::size_t>(space.points.width()) * TopsWorkspace::pitch(rules.disparities)};
  cpu.for_parts(space.points.height(), cpu.threads(), [&](int part, int begin, int end) {
    const auto thread = static_cast<std::size_t>(part);
    std::uint8_t* columns{space.costs.data() + 2 * thread * of_row};
    std::uint8_t* best{space.best.data() + thread * static_cast<std::size_t>(space.points.width())};
    find_top_rows(begin, end, plane, rules, matches, space.points, [&](int v) {
      top_costs(images, v, rules, columns, columns + of_row, best);
      return TopRowCosts{columns + of_row, best};
    });
  });
  cpu.for_parts(space.points.height(), cpu.threads(),
                [&](int, int begin, int end) { put_top_rows(begin, end, space.points, matches); });
}

}  // namespace stereogrid
