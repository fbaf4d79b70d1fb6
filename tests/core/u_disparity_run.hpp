// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "observation/u_disparity/u_disparity.hpp"

namespace stereogrid::test {

/// Everything that `count` makes of two disparity images. The outputs are filled with
/// rubbish before, so that an element that is left out shows.
template <class BackEndType>
StageImages counted(BackEndType& back_end, const Matches& matches, const Rig& rig, const Ground& ground,
                    const BinConfig& config, int disparities, int window_px) {
  const int width{matches.road.width()};
  const int height{matches.road.height()};
  const Image<float> rubbish{width, disparities, -7.0f};
  const Image<std::uint16_t> rubbish_count{width, disparities, 7777};
  StageImages stages;
  stages.possible.assign(static_cast<std::size_t>(disparities), -7);
  stages.visible = stages.observed = rubbish_count;
  stages.visibility = stages.obstacle_confidence = stages.road_confidence = rubbish;
  stages.occupancy = stages.occupancy_smooth = rubbish;
  const UDisparityTables tables{config, height, window_px};
  UDisparityWorkspace space{width, height, disparities, 2};
  count(back_end, matches, rig, ground, tables, space, stages);
  return stages;
}

}  // namespace stereogrid::test
