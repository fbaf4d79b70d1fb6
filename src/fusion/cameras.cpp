// SPDX-License-Identifier: Apache-2.0
#include "fusion/cameras.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/model.hpp"

namespace stereogrid {

void fuse_camera_rows(std::span<const View<const float>> cameras, int begin, int end, View<float> cells) {
  for (int y{begin}; y < end; ++y) {
    for (int x{0}; x < cells.width; ++x) {
      int count{0};
      float seen{0.5f};
      double odds{1};
      for (const View<const float>& camera : cameras) {
        const float p{camera(x, y)};
        if (p == 0.5f) continue;
        const double sure{std::clamp(static_cast<double>(p), 1 - surest, surest)};
        odds *= sure / (1 - sure);
        seen = p;
        ++count;
      }
      if (count > 1) {
        const double mean{count == 2 ? std::sqrt(odds) : std::pow(odds, 1.0 / count)};
        seen = static_cast<float>(mean / (1 + mean));
      }
      cells(x, y) = seen;
    }
  }
}

}  // namespace stereogrid
