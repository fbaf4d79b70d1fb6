// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include "fusion/fusion.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{16};

}  // namespace

void fuse(Cpu& cpu, std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
          View<float> cells) {
  if (others.empty()) return;
  cpu.for_ranges(cells.height, rows_grain,
                 [&](int begin, int end) { fuse_rows(others, grid, config, cells, begin, end); });
}

}  // namespace stereogrid
