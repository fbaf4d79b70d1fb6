// SPDX-License-Identifier: Apache-2.0
#include "fusion/cameras.hpp"

#include "fusion/model.hpp"

namespace stereogrid {

void fuse_camera_rows(std::span<const View<const float>> cameras, int begin, int end, View<float> cells) {
  for (int y{begin}; y < end; ++y) {
    for (int x{0}; x < cells.width; ++x) {
      CameraPool pool;
      for (const View<const float>& camera : cameras) pool.add(camera(x, y));
      cells(x, y) = pool.probability();
    }
  }
}

}  // namespace stereogrid
