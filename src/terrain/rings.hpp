// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host_device.hpp"
#include "memory_bytes.hpp"
#include "numbers.hpp"
#include "stereogrid/config.hpp"
#include "terrain/model.hpp"

namespace stereogrid {

constexpr int no_ring{-1};

/// Rings of a frame, for CPU and GPU: views of the memory of Rings, or of a copy on the device.
struct RingTable {
  static constexpr float places_per_px{16};  ///< borders are multiples of a sixteenth of a pixel

  [[nodiscard]] STEREOGRID_HD int count() const { return rings; }
  [[nodiscard]] STEREOGRID_HD float begin_m(int ring) const { return borders_m[ring]; }
  [[nodiscard]] STEREOGRID_HD float end_m(int ring) const { return borders_m[ring + 1]; }
  [[nodiscard]] STEREOGRID_HD float middle_m(int ring) const { return 0.5f * (begin_m(ring) + end_m(ring)); }
  /// Ring of a disparity > 0; no_ring: before the first or behind the last one.
  [[nodiscard]] STEREOGRID_HD int at_disparity(float disparity) const {
    return at_place(static_cast<int>(Min(disparity * places_per_px, static_cast<float>(places()))));
  }
  [[nodiscard]] STEREOGRID_HD int places() const { return place_max; }
  [[nodiscard]] STEREOGRID_HD int at_place(int place) const { return ring_at[place]; }

  int rings{0};
  int place_max{0};                      ///< place of all disparities beyond the last one
  const float* borders_m{nullptr};       ///< rings + 1
  const std::int16_t* ring_at{nullptr};  ///< by place, place_max + 1
};

/// Rings of the polar grid, from the nearest visible ground outwards. The length of a ring is the longest of a cell,
/// two standard deviations of the range and two rows of the image.
class Rings : public RingTable {
 public:
  Rings(float cell_m, float farthest_m, int disparities);
  Rings(Rings&&) = default;
  Rings(const Rings&) = delete;
  Rings& operator=(const Rings&) = delete;

  /// `nearest_m`: first ground in the image.
  void place(const TerrainCamera& camera, float nearest_m);

  /// Place of all disparities beyond the last one.
  static constexpr int last_place(int disparities) { return (disparities + 1) * static_cast<int>(places_per_px); }
  [[nodiscard]] int capacity() const { return static_cast<int>(borders_.size()) - 1; }
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(borders_, ring_at_); }

 private:
  float cell_m_;
  float farthest_m_;
  std::vector<float> borders_;
  std::vector<std::int16_t> ring_at_;
};

inline Rings::Rings(float cell_m, float farthest_m, int disparities)
    : cell_m_{cell_m},
      farthest_m_{farthest_m},
      borders_(static_cast<std::size_t>(std::ceil(farthest_m / cell_m)) + 2),
      ring_at_(static_cast<std::size_t>(last_place(disparities)) + 1) {
  static_cast<RingTable&>(*this) = {0, last_place(disparities), borders_.data(), ring_at_.data()};
}

/// Rings of a configuration.
inline Rings rings_of(const Config& config) {
  const GridConfig& grid{config.grid};
  return {static_cast<float>(grid.cell_size_m),
          static_cast<float>(std::hypot(std::max(grid.length_m, grid.rear_m), grid.width_m / 2)),
          config.matching.disparities};
}

inline void Rings::place(const TerrainCamera& camera, float nearest_m) {
  std::ranges::fill(ring_at_, static_cast<std::int16_t>(no_ring));
  rings = 0;
  const float focal_baseline{camera.focal_baseline_pxm * places_per_px};
  const float first{std::min(focal_baseline / std::max(nearest_m, cell_m_), static_cast<float>(places()))};
  int place{static_cast<int>(first)};
  float x{focal_baseline / static_cast<float>(std::max(place, 1))};
  while (rings < capacity() && x < farthest_m_) {
    const float length{
        std::max({cell_m_, 2 * camera.range_sigma(x, block_sigma_px), 2 * camera.row_length(camera.height_m, x)})};
    const int next{std::min(place - 1, static_cast<int>(focal_baseline / (x + length)))};
    if (next < 1) break;
    std::fill(ring_at_.begin() + next, ring_at_.begin() + place, static_cast<std::int16_t>(rings));
    borders_[static_cast<std::size_t>(rings)] = x;
    x = focal_baseline / static_cast<float>(next);
    borders_[static_cast<std::size_t>(++rings)] = x;
    place = next;
  }
}

}  // namespace stereogrid
