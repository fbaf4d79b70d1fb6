// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/mask.hpp"

#include <algorithm>
#include <optional>

namespace stereogrid {
namespace {

/// True if one of the source pixels of the levelled pixel at `place`, or the nearest one, is masked.
bool is_masked(const Image<std::uint8_t>& camera, ImagePoint place) {
  const double u{std::clamp(place.u, 0.0, camera.width() - 1.0)};
  const double v{std::clamp(place.v, 0.0, camera.height() - 1.0)};
  const int left{static_cast<int>(u)};
  const int top{static_cast<int>(v)};
  const int right{u > left ? left + 1 : left};
  const int bottom{v > top ? top + 1 : top};
  return camera(left, top) == 0 || camera(right, top) == 0 || camera(left, bottom) == 0 || camera(right, bottom) == 0;
}

}  // namespace

PixelMask::PixelMask(const Image<std::uint8_t>& camera, const LevelMapping& mapping) {
  if (camera.empty()) return;
  Image<std::uint8_t> masked{mapping.level_rig().width_px, mapping.level_rig().height_px};
  for (int v{0}; v < masked.height(); ++v) {
    for (int u{0}; u < masked.width(); ++u) {
      const std::optional<ImagePoint> place{
          mapping.camera_from_level({static_cast<double>(u), static_cast<double>(v)})};
      masked(u, v) = place && is_masked(camera, *place) ? 1 : 0;
    }
    if (std::count(masked.row(v), masked.row(v) + masked.width(), 1) == 0) continue;
    if (end_row_ == 0) first_row_ = v;
    end_row_ = v + 1;
  }
  if (end_row_ > 0) masked_ = std::move(masked);
}

void PixelMask::clear(int begin, int end, Matches& matches) const {
  for (int v{first_row_ + begin}; v < first_row_ + end; ++v) {
    const std::uint8_t* const masked{masked_.row(v)};
    for (Image<float>* const image : {&matches.obstacle, &matches.road, &matches.confidence}) {
      float* const row{image->row(v)};
      for (int u{0}; u < masked_.width(); ++u) row[u] = masked[u] != 0 ? 0.0f : row[u];
    }
  }
}

}  // namespace stereogrid
