// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "observation/u_disparity/model.hpp"
#include "observation/u_disparity/simd.hpp"
#include "observation/u_disparity/u_disparity.hpp"

namespace stereogrid {

UDisparityTables::UDisparityTables(const BinConfig& parameters, int image_height, int window_px)
    : config{parameters},
      half_window{window_px / 2},
      miss(static_cast<std::size_t>(pair_index(image_height + 1, 0))),
      weights_column{gaussian_weights(parameters.sigma_column)},
      weights_disparity{gaussian_weights(parameters.sigma_disparity)} {
  for (int visible{0}; visible <= image_height; ++visible) {
    for (int observed{0}; observed <= visible; ++observed) {
      miss[static_cast<std::size_t>(pair_index(visible, observed))] = miss_of(config, visible, observed);
    }
  }
  for (std::size_t cells{0}; cells < road_factor.size(); ++cells) {
    road_factor[cells] = static_cast<float>(std::exp(-(1 - static_cast<double>(cells) / 9) / config.tau_road));
  }
}

float miss_of(const BinConfig& config, int visible, int observed) {
  if (visible == 0) return 1;
  const double share{static_cast<double>(observed) / (visible + config.small_count_guard)};
  return static_cast<float>(std::exp(-share / config.tau_obstacle));
}

std::vector<float> gaussian_weights(double sigma) {
  if (sigma <= 0) return {1.0f};
  const auto below = [&](double x) { return 0.5 * std::erfc(-x / (sigma * std::numbers::sqrt2)); };
  const int reach{static_cast<int>(std::ceil(3 * sigma))};
  std::vector<double> weights;
  double sum{0};
  for (int k{-reach}; k <= reach; ++k) {
    weights.push_back(below(k + 0.5) - below(k - 0.5));
    sum += weights.back();
  }
  std::vector<float> normalised;
  for (const double weight : weights) normalised.push_back(static_cast<float>(weight / sum));
  return normalised;
}

UDisparityWorkspace::UDisparityWorkspace(int width, int height, int bins, int threads)
    : rows{width, height, bins},
      counts(static_cast<std::size_t>(threads),
             std::vector<std::uint16_t>(static_cast<std::size_t>(bins + 1) * pixel_kinds * block_columns)),
      has_road{width, bins},
      road_columns{width, bins + 1},
      smooth_once{width, bins} {}

}  // namespace stereogrid
