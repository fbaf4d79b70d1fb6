// SPDX-License-Identifier: Apache-2.0
#include "terrain/trenches.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "memory_bytes.hpp"

namespace stereogrid {
namespace {

void write_means(View<const float> medians, int first_row, int sector, float* mean) {
  constexpr int block_rows{64};
  for (int begin{first_row}; begin < medians.width; begin += block_rows) {
    const int end{std::min(begin + block_rows, medians.width)};
    std::array<float, block_rows> sum{};
    std::array<float, block_rows> count{};
    for (int i{-sectors_beside}; i <= sectors_beside; ++i) {
      const float* const disparity{medians.row(std::clamp(sector + i, 0, medians.height - 1)) + begin};
      for (std::size_t k{0}; k < static_cast<std::size_t>(end - begin); ++k) {
        sum[k] += disparity[k];
        count[k] += static_cast<float>(disparity[k] > 0);
      }
    }
    for (int v{begin}; v < end; ++v) {
      const auto k = static_cast<std::size_t>(v - begin);
      mean[v] = mean_of_sectors(sum[k], count[k]);
    }
  }
}

// Sets `bit` of the edges `first` … `end` − 1 that are likely, in a loop that g++ turns into vectors.
void mark_likely(const TrenchSearch& search, const TrenchShape& shape, int first, int end, int bit, int* likely) {
  const float* const d{search.disparity + first - shape.edge_place};
  const TrenchCheck check{search.check(shape)};
  for (int i{0}; i < end - first; ++i) likely[i] |= check.is_likely(d + i) * bit;
}

}  // namespace

std::vector<TrenchShape> trench_shapes_of(int window_rows) {
  const int margin{trench_margin_of(window_rows)};
  std::vector<TrenchShape> shapes;
  for (const int wall_rows : wall_rows_tried) {
    TrenchShape shape{wall_rows, wall_rows + margin, wall_rows + 2 * margin + 1};
    for (int i{0}; i < shape.rows; ++i) {
      const int above{shape.edge_place - i};  // rows above the edge
      float sum{0};
      for (int row{above - window_rows / 2}; row <= above + window_rows / 2; ++row) {
        if (wall_rows == 0) sum += row == 0 ? 0.5f : static_cast<float>(row > 0);
        if (row >= 0 && row <= wall_rows) sum += static_cast<float>(wall_rows - row);
      }
      shape.fall.at(static_cast<std::size_t>(i)) = sum / static_cast<float>(window_rows);
    }
    const float last{static_cast<float>(shape.rows - 1)};
    const int edge{(shape.rows - 1 + wall_rows) / 2};
    std::ranges::transform(std::array{edge, edge + 2, edge - wall_rows / 2}, shape.probes.begin(), [&](int place) {
      return TrenchProbe{place, static_cast<float>(place) / last, shape.fall[static_cast<std::size_t>(place)]};
    });
    shapes.push_back(shape);
  }
  return shapes;
}

TrenchFilter::TrenchFilter(int height_px, int sectors, int window_rows)
    : disparity_{height_px, sectors},
      margin_{trench_margin_of(window_rows)},
      shapes_{trench_shapes_of(window_rows)},
      found_(static_cast<std::size_t>(sectors)) {}

void TrenchFilter::begin(const SampledGround& ground, View<const float> medians) {
  ground_ = ground;
  medians_ = medians;
}

void TrenchFilter::find(int sector) {
  at(sector) = best(search(sector, alone_bounds()), medians_.width, ground_.first_row);
}

void TrenchFilter::find_between(int sector) {
  at(sector).reset();
  const int before{sector - sector % step};
  for (const int there : {before, before + step}) {
    if (there >= disparity_.height() || !at(there)) continue;
    const int row{at(there)->row};
    const std::optional<Trench> found{best(search(sector, alone_bounds()), row + chain_rows, row - chain_rows)};
    if (found && (!at(sector) || found->gain > at(sector)->gain)) at(sector) = found;
  }
}

void TrenchFilter::connect() {
  const int sectors{disparity_.height()};
  const TrenchChains chains{found_.data(), sectors};
  chains.connect(ground_);
  const auto extend = [&](int sector, int side) {
    const Trench* const other{chains.extending(sector, side)};
    if (other == nullptr) return;
    at(sector) = best(search(sector, extension_bounds()), other->row + chain_rows, other->row - chain_rows);
    if (at(sector)) at(sector)->is_sure = true;
  };
  for (int sector{0}; sector < sectors; ++sector) extend(sector, 1);
  for (int sector{sectors - 1}; sector >= 0; --sector) extend(sector, -1);
}

TrenchSearch TrenchFilter::search(int sector, const TrenchBounds& bounds) {
  write_means(medians_, ground_.first_row, sector, disparity_.row(sector));
  return {ground_, sector, bounds, margin_, disparity_.row(sector)};
}

std::optional<Trench> TrenchFilter::best(const TrenchSearch& search, int lowest, int highest) const {
  std::optional<Trench> found;
  const int end{std::min(lowest + 1, medians_.width - margin_)};
  int first{std::max(highest, ground_.first_row + 1)};
  while (first < end && !search.is_near(first)) ++first;
  std::array<int, 64> likely;  // shapes by bits
  const int rows{static_cast<int>(likely.size())};
  for (int edge_end{end}; edge_end > first; edge_end -= rows) {
    const int begin{std::max(first, edge_end - rows)};
    likely = {};
    for (std::size_t k{1}; k < shapes_.size(); ++k) {
      const int from{std::max(begin, search.first_edge(shapes_[k]))};
      if (from < edge_end) mark_likely(search, shapes_[k], from, edge_end, 1 << k, &likely[from - begin]);
    }
    for (int edge{edge_end - 1}; edge >= begin; --edge) {
      if (!(search.disparity[edge] > 0)) continue;
      for (unsigned left{static_cast<unsigned>(likely[edge - begin]) | (search.is_lower(edge) ? 1U : 0U)}; left != 0;
           left &= left - 1) {
        const std::optional<Trench> trench{search.at(shapes_[static_cast<std::size_t>(std::countr_zero(left))], edge)};
        if (trench && (!found || trench->gain > found->gain)) found = trench;
      }
    }
  }
  return found;
}

std::size_t TrenchFilter::memory_bytes() const {
  return memory_bytes_of(disparity_, shapes_, found_);
}

}  // namespace stereogrid
