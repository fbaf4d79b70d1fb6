// SPDX-License-Identifier: Apache-2.0
#include "terrain/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int rule_threads{256};

__global__ void rule_cells(const CellRule* rules, View<float, Device> cells) {
  const int i{static_cast<int>(blockIdx.x) * rule_threads + static_cast<int>(threadIdx.x)};
  if (i >= cells.width * cells.height) return;
  float& cell{cells(i % cells.width, i / cells.width)};
  cell = ruled(cell, rules[i]);
}

}  // namespace

void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells) {
  launch(cuda, rule_cells, blocks_for(cells.width * cells.height, rule_threads), rule_threads, 0, rules, cells);
}

}  // namespace stereogrid
