// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "filter/correction_model.hpp"
#include "filter/filter.hpp"

namespace stereogrid {
namespace {

constexpr int cells_together{16};

bool may_change(const float* seen, const float* occupancies) {
  int changes{0};
  for (int i{0}; i < cells_together; ++i) changes |= FrameCorrection<Host>::may_change(seen[i], occupancies[i]);
  return changes != 0;
}

}  // namespace

void correct_by_frame(const Pose2& world_from_vehicle, bool is_widened, int begin, int end, FrameResult& result) {
  GridLayers& vehicle{result.vehicle};
  const FrameCorrection<Host> correction{
      std::as_const(result.observed).view(), std::as_const(result.world.occupancy).view(),
      grid_in_vehicle(vehicle.geometry, {}),
      places_in_window(grid_in_vehicle(vehicle.geometry, world_from_vehicle), result.world.geometry), is_widened};
  for (int y{begin}; y < end; ++y) {
    const float* const seen{result.observed.row(y)};
    float* const occupancies{vehicle.occupancy.row(y)};
    for (int first{0}; first < result.observed.width(); first += cells_together) {
      const int last{std::min(first + cells_together, result.observed.width())};
      if (last - first == cells_together && !may_change(seen + first, occupancies + first)) continue;
      for (int x{first}; x < last; ++x) correction.correct(x, y, occupancies[x], vehicle.moving(x, y));
    }
  }
}

}  // namespace stereogrid
