// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/terrain.hpp"

#include <algorithm>

namespace stereogrid {

Terrain::Terrain(const Rig& level_rig, const TerrainLimits& limits, float cell_m, float farthest_m, int disparities,
                 int window_px)
    : rig_{level_rig},
      limits_{limits},
      window_rows_{static_cast<float>(window_px)},
      rings_{cell_m, farthest_m, disparities},
      samples_{level_rig.width_px, level_rig.height_px, rings_.capacity()},
      sigma_px_(static_cast<std::size_t>(rings_.capacity())),
      plane_sigma_m_(static_cast<std::size_t>(rings_.capacity())),
      cells_{rings_.capacity(), samples_.sectors()},
      walks_{samples_.sectors(), 1},
      camera_{level_rig, {}} {}

void Terrain::begin(const Ground& ground) {
  ground_ = ground;
  camera_ = TerrainCamera{rig_, ground};
  const float lowest{camera_.tangent(static_cast<float>(rig_.centre_u_px), static_cast<float>(rig_.height_px - 1))};
  rings_.place(camera_, lowest > 0 ? camera_.height_m / lowest : 1e6f);
  samples_.begin(camera_, limits_);
}

void Terrain::begin_walks() {
  samples_.measure_noise(rings_.count(), sigma_px_);
  judged_rings_ = 0;
  bool is_judged{true};
  for (int ring{0}; ring < rings_.count(); ++ring) {
    const auto r = static_cast<std::size_t>(ring);
    const float x{rings_.middle_m(ring)};
    const float row{static_cast<float>(rig_.centre_v_px) + static_cast<float>(rig_.focal_px) * camera_.height_m / x};
    plane_sigma_m_[r] = camera_.elevation_sigma(
        camera_.height_m, x, static_cast<float>(plane_sigma_px(rig_, ground_, rig_.centre_u_px, row)));
    is_judged = is_judged && 2 * camera_.elevation_sigma(camera_.height_m, x, sigma_px_[r]) <= limits_.step_m;
    if (is_judged) judged_rings_ = ring + 1;
  }
}

std::size_t Terrain::held_bytes() const {
  return held_bytes_of(rings_, samples_, sigma_px_, plane_sigma_m_, cells_, walks_);
}

}  // namespace stereogrid
