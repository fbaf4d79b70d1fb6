// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "matching/matching.hpp"
#include "memory_bytes.hpp"
#include "observation/u_disparity/rows.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Parameters of the bins: the volume above the ground, and the paper's model.
struct BinConfig : UDisparityConfig, PaperConfig {};

/// exp() of the small integers that the probabilities are made of, and the smoothing weights. Built once.
struct UDisparityTables {
  UDisparityTables(const BinConfig& config, int image_height, int window_px);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(miss, weights_column, weights_disparity); }

  BinConfig config;
  int half_window{0};                   ///< with left_border, bins with u < d + this stay unknown
  std::vector<float> miss;              ///< [pair_index(N_V, N_O)]: exp(−r_O/τ_O) = 1 − P(C)
  std::array<float, 10> road_factor{};  ///< [road cells among 9]: exp(−(1−r_R)/τ_R)
  std::vector<float> weights_column;    ///< −K … K, sum 1
  std::vector<float> weights_disparity;
};

/// exp(−r_O/τ_O) with r_O = N_O/(N_V + guard), 0 where N_V = 0. eq. 12, 13.
float miss_of(const BinConfig& config, int visible, int observed);

/// The Gaussian's integrals over bins, |k| ≤ ceil(3σ), sum 1. docs/method.md §5.5.
std::vector<float> gaussian_weights(double sigma);

/// Working memory of `count`.
struct UDisparityWorkspace {
  UDisparityWorkspace(int width, int height, int bins, int threads);

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(rows, counts, has_road, road_columns, smooth_once);
  }

  BinRows rows;
  std::vector<std::vector<std::uint16_t>> counts;  ///< [thread] of a block of columns, all 0 between frames
  Image<std::uint8_t> has_road;                    ///< (D, W) 1: the bin holds a road pixel
  Image<std::uint8_t> road_columns;                ///< (D+1, W) bins with a road pixel among u−1, u, u+1
  Image<float> smooth_once;                        ///< (D, W)
};

/// Disparity images to occupancy in the u-disparity plane: counts N_P, N_V, N_O (eq. 9–12), probabilities (eq. 8,
/// 11–15), Gaussian smoothing. The rows of `stages` are the bins. N_P in `stages` is that of the column u0; with roll
/// the image ends earlier or later in others. Fills everything in `stages` but the disparity images.
void count(Cpu& cpu, const Matches& matches, const Rig& rig, const Ground& ground, const UDisparityTables& tables,
           UDisparityWorkspace& space, StageImages& stages);
void count(Reference& reference, const Matches& matches, const Rig& rig, const Ground& ground,
           const UDisparityTables& tables, UDisparityWorkspace& space, StageImages& stages);

}  // namespace stereogrid
