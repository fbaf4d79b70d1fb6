// SPDX-License-Identifier: Apache-2.0
#include "terrain/elevation_memory.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid {
namespace {

// The ground planes of two frames differ by the vehicle's heave, and by its pitch and roll.
constexpr double heave_m{0.05};
constexpr double tilt{0.02};  // rise per m

constexpr int cells_of_error{3};   // neighbours share the matcher's errors: every third one counts
constexpr float frames_most{2};    // frames whose errors are independent
constexpr float contradiction{3};  // standard deviations between two heights of the same ground

template <class T>
bool contradicts(T off, T variance) {
  return !(off * off < contradiction * contradiction * variance);
}

}  // namespace

ElevationMemory::ElevationMemory(double cell_m, int window_cells)
    : cell_m_{cell_m},
      elevation_m_{window_cells, window_cells},
      variance_{window_cells, window_cells},
      frame_{window_cells, window_cells},
      rows_(static_cast<std::size_t>(window_cells)) {
  common_.reserve(frame_.size());
  reset();
}

void ElevationMemory::reset() {
  elevation_m_.fill(unseen);
  variance_.fill(unseen);
}

void ElevationMemory::move(Scroll scroll) {
  scroll_cells(scroll, elevation_m_, unseen);
  scroll_cells(scroll, variance_, unseen);
}

void ElevationMemory::begin_row(int iy) {
  rows_[static_cast<std::size_t>(iy)] = {frame_.width(), 0};
  std::fill_n(frame_.row(iy), frame_.width(), Seen{});
}

void ElevationMemory::see(const ElevationMemory& other) {
  for (int iy{0}; iy < frame_.height(); ++iy) {
    const Range row{other.rows_[static_cast<std::size_t>(iy)]};
    for (int ix{row.begin}; ix < row.end; ++ix) {
      const Seen& seen{other.frame_(ix, iy)};
      const Seen& own{frame_(ix, iy)};
      if (!std::isnan(seen.variance) && !(own.variance <= seen.variance))
        see(ix, iy, seen.elevation_m, std::sqrt(seen.variance));
    }
  }
}

// The plane from the frame up to the memory, by least squares over the common cells. Left out are those that contradict
// `expected`. The prior of heave and tilt decides where there are few.
ElevationMemory::Shift ElevationMemory::difference(const Shift& expected) const {
  double n{1 / (heave_m * heave_m)};
  double x{0}, y{0}, xy{0}, z{0}, xz{0}, yz{0};
  double xx{1 / (tilt * tilt * cell_m_ * cell_m_)}, yy{xx};
  for (const Common& cell : common_) {
    const double off{cell.difference - expected.z - expected.x * cell.x - expected.y * cell.y};
    if (contradicts(off, cell.variance + expected.zz)) continue;
    const double weight{1 / cell.variance};
    n += weight;
    x += weight * cell.x;
    y += weight * cell.y;
    xx += weight * cell.x * cell.x;
    xy += weight * cell.x * cell.y;
    yy += weight * cell.y * cell.y;
    z += weight * cell.difference;
    xz += weight * cell.x * cell.difference;
    yz += weight * cell.y * cell.difference;
  }
  const double cofactor_z{xx * yy - xy * xy};
  const double cofactor_x{xy * y - x * yy};
  const double cofactor_y{x * xy - xx * y};
  const double det{n * cofactor_z + x * cofactor_x + y * cofactor_y};
  Shift found{0,
              0,
              0,
              cofactor_z / det,
              cofactor_x / det,
              cofactor_y / det,
              (n * yy - y * y) / det,
              (x * y - n * xy) / det,
              (n * xx - x * x) / det};
  found.z = found.zz * z + found.zx * xz + found.zy * yz;
  found.x = found.zx * z + found.xx * xz + found.xy * yz;
  found.y = found.zy * z + found.xy * xz + found.yy * yz;
  return found;
}

// In single precision, so that the loop becomes vectors.
void ElevationMemory::shift(const Shift& by) {
  const int cells{elevation_m_.width()};
  const double half{cells / 2.0};
  const auto along_x = static_cast<float>(by.x);
  const auto xx = static_cast<float>(by.xx);
  for (int iy{0}; iy < cells; ++iy) {
    const double y{iy - half};
    const auto z = static_cast<float>(by.z + by.y * y - by.x * half);
    const auto zz = static_cast<float>(by.zz + 2 * by.zy * y + by.yy * y * y);
    const auto zx = static_cast<float>(2 * (by.zx + by.xy * y));
    const auto middle = static_cast<float>(half);
    float* const elevation{elevation_m_.row(iy)};
    float* const variance{variance_.row(iy)};
    for (int ix{0}; ix < cells; ++ix) {
      const float x{static_cast<float>(ix)};
      elevation[ix] -= z + along_x * x;
      variance[ix] += zz + (zx + xx * (x - middle)) * (x - middle);
    }
  }
}

void ElevationMemory::add() {
  const double half{elevation_m_.width() / 2.0};
  const auto for_seen = [this](int step, const auto& work) {
    for (int iy{0}; iy < frame_.height(); iy += step) {
      const Range row{rows_[static_cast<std::size_t>(iy)]};
      for (int ix{(row.begin + step - 1) / step * step}; ix < row.end; ix += step) {
        if (!std::isnan(frame_(ix, iy).elevation_m)) work(ix, iy, frame_(ix, iy));
      }
    }
  };
  common_.clear();
  for_seen(cells_of_error, [&](int ix, int iy, const Seen& seen) {
    const float difference{elevation_m_(ix, iy) - seen.elevation_m};
    if (!std::isnan(difference))
      common_.push_back({ix - half, iy - half, difference, variance_(ix, iy) + seen.variance});
  });
  const double rise_m{tilt * half * cell_m_};
  shift(difference(difference({0, 0, 0, heave_m * heave_m + 2 * rise_m * rise_m, 0, 0, 0, 0, 0})));
  for_seen(1, [&](int ix, int iy, const Seen& seen) {
    float& elevation_m{elevation_m_(ix, iy)};
    float& variance{variance_(ix, iy)};
    const float off{seen.elevation_m - elevation_m};
    const bool is_new{contradicts(off, variance + seen.variance)};  // or the first
    const float gain{is_new ? 1 : variance / (variance + seen.variance)};
    elevation_m = is_new ? seen.elevation_m : elevation_m + gain * off;
    variance = is_new ? seen.variance : std::max((1 - gain) * variance, seen.variance / frames_most);
  });
}

void ElevationMemory::write(Image<float>& elevation_m, Image<float>& sigma_m) const {
  std::ranges::copy(elevation_m_, elevation_m.begin());
  std::ranges::transform(variance_, sigma_m.begin(), [](float variance) { return std::sqrt(variance); });
}

}  // namespace stereogrid
