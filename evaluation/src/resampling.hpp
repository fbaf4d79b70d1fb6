// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <random>
#include <vector>

namespace stereogrid::evaluation {

/// Draws frames with replacement in blocks of neighbours, since a frame is much like the one before it; the last frame
/// is followed by the first (circular block bootstrap, Politis and Romano 1992). Blocks are √n frames long. The same
/// draws on every machine.
class BlockResampler {
 public:
  explicit BlockResampler(std::size_t frames);
  /// Number of draws of each frame; whole blocks, so n draws or slightly more.
  [[nodiscard]] const std::vector<int>& draw();

 private:
  std::size_t block_;
  std::vector<int> times_;
  std::mt19937_64 random_{20120901};
};

/// The value that `share` of the values are below, NaN left out; NaN where most are NaN.
[[nodiscard]] double quantile(std::vector<double> values, double share);

}  // namespace stereogrid::evaluation
