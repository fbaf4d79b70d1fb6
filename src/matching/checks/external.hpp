// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "geometry/relief.hpp"
#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "matching/matching.hpp"
#include "numbers.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Matches from external disparities, which come without a hypothesis. Before the terrain is known, the height over the
/// ground plane separates road and obstacles, afterwards the surface that the pixels around a pixel lie on.

/// Tests whether a disparity d lies on the road with disparity r at the pixel. A point at height h above a plane at
/// distance H has d = r·H/(H − h). Off the road are heights beyond ± road_height_m with a difference d − r beyond two
/// standard deviations: noise of the disparity, and the plane's own, σ² = σ_d² + (r σ_H/H)² + (b/H)² ((f σ_pitch)² +
/// (x σ_roll)²) with x = u − u0 and σ_d = external_sigma_px, or half a pixel where that is 0.
struct HeightTest {
  static constexpr float never{std::numeric_limits<float>::infinity()};

  STEREOGRID_HD HeightTest(const Rig& rig, const Ground& ground, const MatchingConfig& config);

  [[nodiscard]] STEREOGRID_HD float margin2(float r, float x) const {
    return constant + per_r2 * (r * r) + per_x2 * (x * x);
  }
  [[nodiscard]] STEREOGRID_HD bool is_on_road(float d, float r, float x) const {
    const bool is_level{(d <= r || d <= r * above) && d >= r * below};
    return is_level || (d - r) * (d - r) <= margin2(r, x);
  }

  float constant;  ///< constant part of margin², px²
  float per_r2;
  float per_x2;
  float above;  ///< d/r at the height road_height_m
  float below;
};

STEREOGRID_HD inline HeightTest::HeightTest(const Rig& rig, const Ground& ground, const MatchingConfig& config) {
  constexpr double significance{2};      // standard deviations
  constexpr double road_height_m{0.15};  // lower above the plane is road
  constexpr double assumed_sigma_px{0.5};
  const auto squared = [](double deviation) {
    return static_cast<float>(significance * deviation * significance * deviation);
  };
  const double scale{rig.baseline_m / ground.height_m};
  const double share{road_height_m / ground.height_m};
  constant = squared(config.external_sigma_px > 0 ? config.external_sigma_px : assumed_sigma_px) +
             squared(scale * rig.focal_px * ground.pitch_sigma_rad);
  per_r2 = squared(ground.height_sigma_m / ground.height_m);
  per_x2 = squared(scale * ground.roll_sigma_rad);
  above = share < 1 ? static_cast<float>(1 / (1 - share)) : never;
  below = static_cast<float>(1 / (1 + share));
}

/// Bin 0 is "no measurement", and the u-disparity plane ends. NaN is not usable.
STEREOGRID_HD inline bool is_usable(float disparity, int disparities) {
  return disparity >= 0.5f && disparity < static_cast<float>(disparities) - 0.5f;
}

/// Step of disparities that are rounded to whole, half or quarter pixels, px; 0: finer.
double step_of(View<const float> disparity);

/// Message where a quarter or more of the disparities are outside the search range and not used; "": they are not.
std::string excess_of(View<const float> disparity, int disparities);

/// `Matches` of an external disparity.
struct SplitDisparity {
  float obstacle;
  float road;
};

STEREOGRID_HD inline SplitDisparity labelled(float d, bool is_road) {
  return is_road ? SplitDisparity{0, d} : SplitDisparity{d, 0};
}

/// Disparities of the ground along a row.
struct GroundRow {
  STEREOGRID_HD GroundRow(const RoadPlane& plane, int v)
      : centre_u{static_cast<float>(plane.cx_px)},
        per_u{static_cast<float>(plane.per_u)},
        per_v{static_cast<float>(plane.per_v)},
        at_centre{static_cast<float>(plane.disparity(plane.cx_px, v))} {}

  /// Disparity of the ground plane.
  [[nodiscard]] STEREOGRID_HD float at(int u) const { return at_centre + per_u * x_of(u); }
  /// Disparity of the local ground, at the pixel with disparity d.
  template <class Space>
  [[nodiscard]] STEREOGRID_HD float at(int u, float d, const Relief<Space>& relief) const {
    return relief.is_plane() ? at(u) : at(u) + per_v * static_cast<float>(relief.rows_at(u, d));
  }
  [[nodiscard]] STEREOGRID_HD float x_of(int u) const { return static_cast<float>(u) - centre_u; }

  float centre_u;
  float per_u;
  float per_v;
  float at_centre;
};

/// Pixels to either side whose disparities determine the surface of a pixel: the rows of the default matching window.
constexpr int surface_rows{4};
constexpr int surface_columns{1};
/// With fewer of them the height test decides.
constexpr int surface_pixels_min{3};

/// Evidence of the pixels around one for a surface along the ground against an upright one: the sum of the squared
/// differences to the pixel, of the disparities less that of the heights over the ground, each at most 1 px².
struct SurfaceEvidence {
  float sum{0};
  int pixels{0};

  /// A neighbour: disparity, and its difference to the ground's there; d and h: the pixel's.
  STEREOGRID_HD void add(float other_d, float other_h, float d, float h) {
    const float upright{other_d - d};
    const float along{other_h - h};
    sum += Min(upright * upright, 1.0f) - Min(along * along, 1.0f);
    ++pixels;
  }
};

/// Label of a usable disparity d, `h` over the ground's: road within the matcher's search around the ground, if the
/// pixels around it lie along the ground. Other disparities, below the ground, too, are of obstacles, as of surfaces
/// that are matched upright.
STEREOGRID_HD inline SplitDisparity surface_label(float d, float h, float x, const SurfaceEvidence& around,
                                                  const HeightTest& test) {
  if (std::abs(h) > static_cast<float>(road_margin_px)) return labelled(d, false);
  return labelled(d, around.pixels >= surface_pixels_min ? around.sum > 0 : test.is_on_road(d, d - h, x));
}

/// Splits `disparity` (px; NaN or ≤ 0: none) by the height over the ground plane: on it road, above or below it
/// obstacle. Disparities below 0.5 px or beyond the bins of the u-disparity plane are left out.
void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches);
void split(Reference& reference, View<const float> disparity, const Rig& rig, const Ground& ground,
           const MatchingConfig& config, Matches& matches);

/// Splits `disparity` by the surfaces on the local ground, `relief` over the plane. `heights`: working memory of the
/// image's size.
void split_surfaces(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground,
                    const Relief<Host>& relief, const MatchingConfig& config, Image<float>& heights, Matches& matches);
void split_surfaces(Reference& reference, View<const float> disparity, const Rig& rig, const Ground& ground,
                    const Relief<Host>& relief, const MatchingConfig& config, Image<float>& heights, Matches& matches);

}  // namespace stereogrid
