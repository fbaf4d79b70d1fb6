// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "filter/correction_model.hpp"
#include "filter/filter.hpp"

namespace stereogrid {

void correct_by_frame(const Pose2& world_from_vehicle, bool is_widened, int begin, int end, FrameResult& result) {
  GridLayers& vehicle{result.vehicle};
  const FrameCorrection<Host> correction{
      std::as_const(result.observed).view(), std::as_const(result.world.occupancy).view(),
      grid_in_vehicle(vehicle.geometry, {}),
      places_in_window(grid_in_vehicle(vehicle.geometry, world_from_vehicle), result.world.geometry), is_widened};
  for (int y{begin}; y < end; ++y) {
    const float* const seen{result.observed.row(y)};
    float* const occupancies{vehicle.occupancy.row(y)};
    const auto stays = [&](int first) {
      return !any_of_group(first, [&](int x) { return correction.may_change(seen[x], occupancies[x]); });
    };
    for_groups(result.observed.width(), stays,
               [&](int x) { correction.correct(x, y, occupancies[x], vehicle.moving(x, y)); });
  }
}

}  // namespace stereogrid
