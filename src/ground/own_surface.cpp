// SPDX-License-Identifier: Apache-2.0
#include "ground/own_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace stereogrid {
namespace {

constexpr double step_m{0.5};  // between compared images
constexpr int comparisons_min{4};
constexpr int textured_grey{8};
// Share of a row's textured pixels that stay.
constexpr double same_min{0.7};
// Share of all textured pixels that change where the vehicle travels; of a static scene a tenth at most.
constexpr double travelled_min{0.4};
constexpr int textured_min{8};  // pixels of a row, per comparison
constexpr int blank_rows_max{3};

}  // namespace

OwnSurface::OwnSurface(const Rig& level_rig)
    : rig_{level_rig}, lattice_{level_rig.width_px, level_rig.height_px}, first_row_{level_rig.height_px} {
  const auto rows{static_cast<std::size_t>(lattice_.down)};
  gradients_.resize(rows * static_cast<std::size_t>(lattice_.across));
  rows_.resize(rows);
  seen_.resize(rows);
}

bool OwnSurface::update(View<const std::uint8_t> left, View<const std::uint8_t> masked, Point2 place) {
  if (has_reference_ && std::hypot(place.x - place_.x, place.y - place_.y) < step_m) return false;
  place_ = place;
  compare(left, masked);
  if (!std::exchange(has_reference_, true)) return is_in_view();
  Row all;
  for (const Row& row : seen_) all.add(row);
  if (all.changed < travelled_min * (all.same + all.changed)) return false;
  for (std::size_t j{0}; j < rows_.size(); ++j) rows_[j].add(seen_[j]);
  if (++comparisons_ < comparisons_min) return false;
  return std::exchange(first_row_, row_of_vehicle()) != first_row_;
}

// Gradients at the lattice, and how many of the textured ones have stayed, by row.
void OwnSurface::compare(View<const std::uint8_t> left, View<const std::uint8_t> masked) {
  std::size_t at{0};
  for (int j{0}; j < lattice_.down; ++j) {
    const int v{MatchLattice::first_v + j * MatchLattice::step_v};
    Row& row{seen_[static_cast<std::size_t>(j)]};
    row = {};
    for (int i{0}; i < lattice_.across; ++i, ++at) {
      const int u{MatchLattice::first_u + i * MatchLattice::step_u};
      const int now{left(u + 1, v) - left(u - 1, v)};
      const int before{gradients_[at]};
      gradients_[at] = static_cast<std::int16_t>(now);
      const bool is_masked{!masked.empty() && masked(u, v) != 0};
      if (is_masked || std::abs(before) < textured_grey) continue;
      ++(2 * std::abs(now - before) > std::abs(before) ? row.changed : row.same);
    }
  }
}

// From the lowest row up to the first one that shows the street.
int OwnSurface::row_of_vehicle() const {
  int first_row{rig_.height_px};
  int blank{0};
  for (int j{lattice_.down - 1}; j >= 0 && blank <= blank_rows_max; --j) {
    const Row& row{rows_[static_cast<std::size_t>(j)]};
    const int textured{row.same + row.changed};
    const bool is_blank{textured < textured_min * comparisons_};
    blank = is_blank ? blank + 1 : 0;
    if (is_blank) continue;
    if (row.same < same_min * textured) break;
    first_row = MatchLattice::first_v + j * MatchLattice::step_v - MatchLattice::step_v;
  }
  return first_row;
}

void OwnSurface::continue_from(const OwnSurface& before, double pitch_rad) {
  if (!before.is_in_view()) return;
  const double angle{std::atan((before.first_row_ - before.rig_.cy_px) / before.rig_.focal_px) + pitch_rad};
  const double row{rig_.cy_px + rig_.focal_px * std::tan(angle)};
  first_row_ = static_cast<int>(std::clamp(row, 0.0, 1.0 * rig_.height_px));
}

void report(const OwnSurface& found, FrameResult& result) {
  if (!found.is_in_view()) return;
  result.warnings.push_back(
      {"the lowest rows of the image show the vehicle itself: the ground is not searched there. Give a mask; "
       "`stereogrid info --propose-mask FILE.png` draws one."});
}

}  // namespace stereogrid
