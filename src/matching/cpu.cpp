// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "matching/census_simd.hpp"
#include "matching/correlate_simd.hpp"
#include "matching/matching.hpp"
#include "matching/semi_global.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};

void census_rows(View<const std::uint8_t> grey, View<std::uint32_t> descriptors, int begin, int end) {
  constexpr int rows{2 * census_half_v + 1};
  const int width{grey.width};
  const int stride{width + 2 * census_half_u + census_padding};
  std::vector<std::uint8_t> padded(static_cast<std::size_t>(rows * stride));
  std::vector<std::uint32_t> row(static_cast<std::size_t>(width + census_padding));
  for (int v{begin}; v < end; ++v) {
    const std::uint8_t* window[rows];
    for (int j{0}; j < rows; ++j) {
      const std::uint8_t* source{grey.row(std::clamp(v + j - census_half_v, 0, grey.height - 1))};
      std::uint8_t* target{padded.data() + j * stride};
      std::fill(target, target + census_half_u, source[0]);
      std::copy(source, source + width, target + census_half_u);
      std::fill(target + census_half_u + width, target + stride, source[width - 1]);
      window[j] = target + census_half_u;
    }
    census_row(window, width, row.data());
    std::copy(row.data(), row.data() + width, descriptors.row(v));
  }
}

void shear_rows(View<const std::uint8_t> right, const RoadPlane& plane, View<std::uint8_t> out, int begin, int end) {
  for (int v{begin}; v < end; ++v) {
    for (int u{0}; u < right.width; ++u) {
      out(u, v) = sheared(right.row(v), right.width, u, shear_of(plane.disparity(u, v)));
    }
  }
}

// Sum over the window of |L(u+1) − L(u−1)|, by sliding sums; the border is repeated.
void texture_rows(View<const std::uint8_t> left, const MatchingConfig& config, View<std::uint8_t> textured, int begin,
                  int end) {
  const int width{left.width};
  const int half{config.window_px / 2};
  const double least{config.texture * config.window_px * config.window_px};
  std::vector<int> columns(static_cast<std::size_t>(width), 0);
  const auto add_row = [&](int v, int sign) {
    const std::uint8_t* row{left.row(std::clamp(v, 0, left.height - 1))};
    for (int u{0}; u < width; ++u) {
      columns[static_cast<std::size_t>(u)] +=
          sign * std::abs(row[std::min(u + 1, width - 1)] - row[std::max(u - 1, 0)]);
    }
  };
  const auto column = [&](int u) { return columns[static_cast<std::size_t>(std::clamp(u, 0, width - 1))]; };
  for (int v{begin - half}; v < begin + half; ++v) add_row(v, 1);
  for (int v{begin}; v < end; ++v) {
    add_row(v + half, 1);
    int sum{0};
    for (int i{-half}; i < half; ++i) sum += column(i);
    for (int u{0}; u < width; ++u) {
      sum += column(u + half);
      textured(u, v) = sum >= least ? 1 : 0;
      sum -= column(u - half);
    }
    add_row(v - half, -1);
  }
}

}  // namespace

std::string_view simd_target() {
  return correlate_target();
}

void correlate(Cpu& cpu, View<const std::uint32_t> left, View<const std::uint32_t> right, Shifts shifts,
               const MatchingConfig& config, std::vector<std::uint8_t>& memory, View<Candidate> candidates) {
  constexpr std::size_t alignment{64};
  const int half{config.window_px / 2};
  const int bands{std::min(cpu.threads(), left.height)};
  const std::size_t band_memory{correlate_memory(left.width, shifts, half)};
  memory.resize(std::max(memory.size(), alignment + static_cast<std::size_t>(bands) * band_memory));
  auto* const start{memory.data() + (alignment - reinterpret_cast<std::uintptr_t>(memory.data()) % alignment)};
  cpu.for_parts(left.height, bands, [&](int part, int begin, int end) {
    correlate_band({left, right, shifts, half, config.left_right_px, begin, end,
                    start + static_cast<std::size_t>(part) * band_memory, candidates});
  });
}

void match(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingSpace& space, Matches& matches) {
  const int height{left.height};
  const CensusTriple census{space.census_left.view(), space.census_right.view(), space.census_sheared.view()};
  cpu.for_ranges(height, rows_grain, [&](int begin, int end) {
    census_rows(left, space.census_left.view(), begin, end);
    census_rows(right, space.census_right.view(), begin, end);
    shear_rows(right, plane, space.sheared_right.view(), begin, end);
    texture_rows(left, config, space.textured.view(), begin, end);
  });
  cpu.for_ranges(height, rows_grain, [&](int begin, int end) {
    census_rows(space.sheared_right.view(), space.census_sheared.view(), begin, end);
  });
  if (config.method == MatchingMethod::semi_global) {
    optimise(cpu, census, plane, config, space.memory, space.upright.view(), space.level.view());
  } else {
    correlate(cpu, census.left, census.right, upright_shifts(config), config, space.memory, space.upright.view());
    correlate(cpu, census.left, census.sheared, road_shifts(config), config, space.memory, space.level.view());
  }
  cpu.for_ranges(height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) decide_row(v, plane, config, space, matches);
  });
  remove_speckles(config.speckle_px, space.patch, matches);
}

}  // namespace stereogrid
