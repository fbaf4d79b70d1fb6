// SPDX-License-Identifier: Apache-2.0
#include "terrain/terrain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numbers.hpp"

namespace stereogrid {

Terrain::Terrain(const Rig& level_rig, const TerrainLimits& limits, Rings rings, int disparities)
    : rig_{level_rig},
      limits_{limits},
      rings_{std::move(rings)},
      noise_px_(static_cast<std::size_t>(rings_.places()) + 1),
      plane_sigma_m_(static_cast<std::size_t>(rings_.capacity())),
      relief_{terrain_sectors(level_rig.width_px), rings_.capacity(), disparities, level_rig.height_px},
      observed_rings_(static_cast<std::size_t>(terrain_sectors(level_rig.width_px))),
      camera_{level_rig, {}} {}

void Terrain::begin(const Ground& ground, const Ground& surface) {
  ground_ = ground;
  prior_ = first_ground(ground, surface);
  camera_ = TerrainCamera{rig_, ground};
  const float lowest{camera_.tangent(static_cast<float>(rig_.cx_px), static_cast<float>(rig_.height_px - 1))};
  const float approach{lowest + prior_.slope};  // the lowest ray comes nearer to the surface by this, per m
  rings_.place(camera_, approach > 0 ? (camera_.height_m - prior_.z) / approach : 1e6f);
  sampled_ = {camera_, limits_, rig_.width_px, rig_.height_px};
}

void Terrain::set_noise(const float* sigma_px) {
  for (std::size_t place{0}; place < noise_px_.size(); ++place)
    noise_px_[place] = sigma_px[std::max(rings_.at_place(static_cast<int>(place)), 0)];
  for (int ring{0}; ring < rings_.count(); ++ring) {
    const float x{rings_.middle_m(ring)};
    const float row{static_cast<float>(rig_.cy_px) + static_cast<float>(rig_.focal_px) * camera_.height_m / x};
    plane_sigma_m_[static_cast<std::size_t>(ring)] = camera_.elevation_sigma(
        camera_.height_m, x, static_cast<float>(plane_sigma_px(rig_, ground_, rig_.cx_px, row)));
  }
  checked_rings_ = checked_rings_of(sampled_, rings_, sigma_px);
  walked_ = {{}, {}, sigma_px};
  relief_.begin(camera_, limits_, rings_, sigma_px, prior_);
}

void Terrain::count_observed_rings() {
  const auto is_unknown = [](const PolarCell& cell) {
    return cell.kind == TerrainClass::unknown && std::isnan(cell.elevation_m);
  };
  for (int sector{0}; sector < sectors(); ++sector) {
    int& ring{observed_rings_[static_cast<std::size_t>(sector)]};
    ring = rings_.count();
    while (ring > 0 && is_unknown(walked_.cells(ring - 1, sector))) --ring;
  }
}

void Terrain::CellSpan::clip(float start, float step) {
  if (step == 0) {
    if (start < 0) end = begin;
    return;
  }
  const int root{static_cast<int>(std::clamp(-start / step, -1.0f, static_cast<float>(end)))};
  step > 0 ? begin = std::max(begin, root) : end = std::min(end, root + 1);
}

// Between the first and the last observed ring, and in the image; and a cell more, for what rounding may shift.
Terrain::CellSpan Terrain::observed_cells(const CellPlaces& cells, float half_m, int iy, int nx) const {
  const int observed_rings{std::ranges::max(observed_rings_)};
  if (observed_rings == 0) return {0, 0};
  const float x{cells.x_of(0, iy)};
  const float y{cells.y_of(0, iy)};
  const float margin_m{3 * half_m};
  CellSpan span{0, nx};
  // sum of a · x, b · y and c is at least 0
  const auto clip = [&](float a, float b, float c) {
    span.clip(a * x + b * y + c, a * cells.along + b * cells.across);
  };
  clip(1, 0, margin_m - rings_.begin_m(0));
  clip(-1, 0, margin_m + rings_.end_m(observed_rings - 1));
  const float focal_px{camera_.focal_px};
  const float left_px{static_cast<float>(rig_.cx_px) + 0.5f};
  clip(left_px, -focal_px, focal_px * margin_m);
  clip(static_cast<float>(rig_.width_px) - left_px, focal_px, focal_px * margin_m);
  return span;
}

PolarGeometry Terrain::polar_geometry(float half_m) const {
  return {camera_.focal_px,
          camera_.focal_baseline_pxm,
          static_cast<float>(rig_.cx_px) + 0.5f,
          static_cast<float>(rig_.width_px),
          sectors() - 1,
          half_m,
          static_cast<float>(rings_.places()),
          Rings::places_per_px};
}

// Between the borders of a group of cells, which see straight lines, ring and sectors lie between theirs; and a sector
// more, for what rounding may shift.
bool Terrain::has_no_ground(const PolarPlaces& borders, std::size_t group) const {
  const std::size_t next{group + 1};
  const bool are_ahead{borders.last[group] >= borders.first[group] && borders.last[next] >= borders.first[next]};
  const int ring{rings_.at_place(std::max(borders.ring[group], borders.ring[next]))};
  if (!are_ahead || ring == no_ring) return false;
  const int first{std::max(std::min(borders.first[group], borders.first[next]) - 1, 0)};
  const int last{std::min(std::max(borders.last[group], borders.last[next]) + 1, sectors() - 1)};
  return std::all_of(observed_rings_.begin() + first, observed_rings_.begin() + last + 1,
                     [ring](int observed) { return observed <= ring; });
}

bool Terrain::sees_no_ground_at(Point2 at, float half_m) const {
  const PolarPlace place{polar_place(polar_geometry(half_m), static_cast<float>(at.x), static_cast<float>(at.y))};
  const int ring{polar_ground().ring_of(place)};
  if (ring == no_ring || ring >= checked_rings_) return false;
  for (int sector{place.first}; sector <= place.last; ++sector) {
    const PolarCell* const cells{walked_.cells.row(sector)};
    int before{ring};
    while (before > 0 && cells[before].kind == TerrainClass::unknown) --before;
    if (!cells[before].is_ground()) return false;
  }
  return true;
}

void Terrain::add_edges(std::vector<EdgePoint>& edges) const {
  for (int sector{0}; sector < sectors(); ++sector) {
    const SectorWalk& walk{walked_.walks(sector, 0)};
    if (walk.end == no_ring || walked_.cells(walk.end, sector).kind != TerrainClass::drop) continue;
    const double x{rings_.begin_m(walk.end)};
    const double u{(sector + 0.5) * sector_px - 0.5};
    edges.push_back({sector, {x, (rig_.cx_px - u) * x / rig_.focal_px}, walk.end_fall_m});
  }
}

std::size_t Terrain::memory_bytes() const {
  return memory_bytes_of(rings_, noise_px_, plane_sigma_m_, observed_rings_, relief_);
}

}  // namespace stereogrid
