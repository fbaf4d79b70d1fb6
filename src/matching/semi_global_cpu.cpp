// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "backend/cpu.hpp"
#include "matching/semi_global.hpp"
#include "matching/semi_global_simd.hpp"

namespace stereogrid {

Penalties penalties_of(const MatchingConfig& config) {
  return {config.penalty_step, config.penalty_jump, config.penalty_change};
}

void optimise(Cpu& cpu, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              std::vector<std::uint8_t>& memory, std::vector<RowCandidates>& rows, CandidateSink& sink) {
  constexpr std::size_t alignment{64};
  const int width{census.left.width};
  const int height{census.left.height};
  SemiGlobalTask task{
      census,  plane, penalties_of(config), upright_shifts(config), road_shifts(config), uniqueness_1024(config),
      nullptr, &sink};
  const std::size_t pixels{static_cast<std::size_t>(width) * static_cast<std::size_t>(height)};
  const std::size_t sums{pixels * semi_global_labels(task) * sizeof(std::uint16_t)};
  const std::size_t part_memory{(semi_global_memory(task) + alignment - 1) / alignment * alignment};
  const int parts{cpu.threads()};
  memory.resize(std::max(memory.size(), alignment + sums + static_cast<std::size_t>(parts) * part_memory));
  auto* const start{memory.data() + (alignment - reinterpret_cast<std::uintptr_t>(memory.data()) % alignment)};
  task.sums = reinterpret_cast<std::uint16_t*>(start);
  const auto room = [&](int part) { return start + sums + static_cast<std::size_t>(part) * part_memory; };
  cpu.for_parts(height, parts, [&](int part, int begin, int end) { semi_global_rows(task, begin, end, room(part)); });
  cpu.for_parts(width, parts, [&](int part, int begin, int end) { semi_global_columns(task, begin, end, room(part)); });
  cpu.for_parts(height, parts, [&](int part, int begin, int end) {
    semi_global_choose(task, begin, end, room(part), rows[static_cast<std::size_t>(part)]);
  });
}

}  // namespace stereogrid
