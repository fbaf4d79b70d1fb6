// SPDX-License-Identifier: Apache-2.0
#include "terrain/walk.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid {
namespace {

constexpr float ground_share{0.25f};  ///< share of the rows in which a surface is visible

}  // namespace

RingView::RingView(const WalkInput& input, const SectorRows& sector, int index)
    : in{&input},
      rows{sector},
      ring{index},
      begin_m{input.rings.begin_m(index)},
      end_m{input.rings.end_m(index)},
      x{input.rings.middle_m(index)},
      sigma_px{input.sigma_px[index]} {}

float RingView::predicted_rows(float z, float slope) const {
  const float half_m{0.5f * slope * (end_m - begin_m)};
  const float h{in->camera.height_m - z};
  return ((h + half_m) / begin_m - (h - half_m) / end_m) / in->camera.tangent_per_v;
}

// The foot of an object.
bool RingView::is_upright(int v) const {
  return in->camera.is_upright(rows.growth(v), rows.x[v] * (rows.tangent(static_cast<float>(v)) + in->limits.slope));
}

RingSamples RingView::gather(float z, float slope, float tolerance) const {
  RingSamples found;
  const float step{in->limits.step_m};
  const float like_slope{2 * in->limits.slope * in->camera.range_sigma(x, sigma_px)};  // (6)
  const float lowest_above{std::max({step, 2.5f * sigma(z, slope), like_slope})};
  for (int v{rows.first[ring]}; v != no_row; v = rows.next[v]) {
    const float on_surface{rows.z[v] - slope * (rows.x[v] - x)};
    const float over{on_surface - z};
    if (std::abs(over) < tolerance && !(over > 0.3f * step && is_upright(v))) {
      ++found.ground;
      found.ground_z += on_surface;
    }
    if (over <= lowest_above || over > in->limits.height_m) continue;
    ++found.above;
    found.is_standing = found.is_standing || over < lowest_above + step;
    found.top = std::max(found.top, rows.z[v]);
  }
  return found;
}

bool RingView::has_ground(const RingSamples& samples, float z, float slope) const {
  return samples.ground > 0 && static_cast<float>(samples.ground) >= ground_share * predicted_rows(z, slope);
}

// An obstacle has 30 % of the rows of a level top or of a face of two thirds of a step, whichever has fewer.
bool RingView::has_obstacle(const RingSamples& samples, float z) const {
  const float step{in->limits.step_m};
  const float face_rows{step * 2 / 3 / (x * in->camera.tangent_per_v)};
  const float top_rows{(in->camera.height_m - z - step) * (end_m - begin_m) / (x * x * in->camera.tangent_per_v)};
  const float fewest{std::max(2.0f, 0.3f * std::min(face_rows, std::max(top_rows, 0.0f)))};
  return static_cast<float>(samples.above) >= fewest;
}

int RingView::row_through(float z_near, float z_far) const {
  const float height{in->camera.height_m};
  const auto row_at = [&](float z, float at_x) {
    return ((height - z) / at_x - rows.tangent_at_row_0) / rows.tangent_per_v;
  };
  const int lowest{std::min(static_cast<int>(std::floor(row_at(z_near, begin_m))), rows.end_row - 1)};
  const int highest{std::max(static_cast<int>(std::ceil(row_at(z_far, end_m))), rows.first_row)};
  const float behind_m{end_m + 2.5f * in->camera.range_sigma(x, sigma_px)};
  int valid{0};
  int through{0};
  int first{no_row};
  for (int v{lowest}; v >= highest; --v) {
    if (!(rows.disparity[v] > 0)) continue;
    ++valid;
    if (rows.x[v] < behind_m || rows.z[v] > std::min(z_near, z_far)) continue;
    ++through;
    if (first == no_row) first = v;
  }
  return 2 * through >= valid ? first : no_row;
}

}  // namespace stereogrid
