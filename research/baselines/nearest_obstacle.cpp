// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <utility>
#include <vector>

#include "baselines/columns.hpp"

namespace stereogrid::research {
namespace {

/// Connected surfaces of a disparity image: neighbours that differ by at most 1 px belong together.
class Surfaces {
 public:
  explicit Surfaces(View<const float> disparity) : disparity_{disparity}, done_{disparity.width, disparity.height} {}

  /// The pixels with disparity that belong to surfaces of at least that many.
  [[nodiscard]] Image<float> without_spikes(int pixels_min) {
    Image<float> kept{disparity_.width, disparity_.height};
    for (int v{0}; v < disparity_.height; ++v) {
      for (int u{0}; u < disparity_.width; ++u) {
        if (disparity_(u, v) <= 0 || done_(u, v) != 0) continue;
        collect(u, v);
        if (std::ssize(surface_) < pixels_min) continue;
        for (const auto& [su, sv] : surface_) kept(su, sv) = disparity_(su, sv);
      }
    }
    return kept;
  }

 private:
  void collect(int u, int v) {
    surface_.assign(1, {u, v});
    done_(u, v) = 1;
    for (std::size_t next{0}; next < surface_.size(); ++next) {
      const auto [su, sv]{surface_[next]};
      const float d{disparity_(su, sv)};
      visit(su - 1, sv, d);
      visit(su + 1, sv, d);
      visit(su, sv - 1, d);
      visit(su, sv + 1, d);
    }
  }
  void visit(int u, int v, float neighbour) {
    if (u < 0 || v < 0 || u >= disparity_.width || v >= disparity_.height || done_(u, v) != 0) return;
    if (disparity_(u, v) <= 0 || std::abs(disparity_(u, v) - neighbour) > 1) return;
    done_(u, v) = 1;
    surface_.emplace_back(u, v);
  }

  View<const float> disparity_;
  Image<std::uint8_t> done_;
  std::vector<std::pair<int, int>> surface_;
};

/// Pixels and their summed disparities in each bin of 1 px of a column.
struct Bin {
  double pixels{0};
  double disparities{0};
};

std::vector<Bin> bins_of(const DisparityFrame& frame, const Image<float>& obstacle, const RoadModel& road, int u,
                         const NearestObstacleParameters& parameters) {
  std::vector<Bin> bins(static_cast<std::size_t>(frame.disparities) + 1);
  for (int v{0}; v < obstacle.height(); ++v) {
    const double d{static_cast<double>(obstacle(u, v))};
    if (d <= 0.5 || d > frame.disparities) continue;
    const double height_m{road.height_m(u, v, d)};
    if (height_m < parameters.height_min_m || height_m > parameters.height_max_m) continue;
    Bin& bin{bins[static_cast<std::size_t>(std::lround(d))]};
    bin.pixels += 1;
    bin.disparities += d;
  }
  return bins;
}

// The largest disparity that enough pixels have, give or take one; 0: none.
double nearest(const std::vector<Bin>& bins, double pixels_per_px) {
  for (std::size_t d{bins.size() - 1}; d > 0; --d) {
    Bin around;
    for (std::size_t k{d - 1}; k <= std::min(d + 1, bins.size() - 1); ++k) {
      around.pixels += bins[k].pixels;
      around.disparities += bins[k].disparities;
    }
    if (around.pixels >= 1 && around.pixels >= pixels_per_px * static_cast<double>(d)) {
      return around.disparities / around.pixels;
    }
  }
  return 0;
}

}  // namespace

Image<float> nearest_obstacle_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                   const NearestObstacleParameters& parameters) {
  const Image<float> obstacle{Surfaces{frame.obstacle}.without_spikes(parameters.spike_px)};
  const RoadModel road{frame.rig, frame.ground};
  std::vector<double> farthest(static_cast<std::size_t>(obstacle.width()));
  if (parameters.open_road) farthest = farthest_road(frame);
  const double pixels_per_px{parameters.filled_m / frame.rig.baseline_m};
  std::vector<ColumnBoundary> columns;
  for (int u{0}; u < obstacle.width(); ++u) {
    columns.push_back(
        {nearest(bins_of(frame, obstacle, road, u, parameters), pixels_per_px), farthest[static_cast<std::size_t>(u)]});
  }
  return boundary_grid(frame, columns, parameters.grid, parameters.levels, grid);
}

}  // namespace stereogrid::research
