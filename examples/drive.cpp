// SPDX-License-Identifier: Apache-2.0
//
// drive FOLDER: occupancy grids of a recorded drive (docs/input.md).
#include <algorithm>
#include <cstdio>

#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"

int main(int count, char** arguments) {
  if (count != 2) return 64;
  stereogrid::io::InputArguments input;
  input.paths = {arguments[1]};
  const auto recording{stereogrid::io::open_recording(input)};
  stereogrid::Pipeline pipeline{stereogrid::preset("default"), recording->rig()};
  for (std::size_t i{0}; i < recording->size(); ++i) {
    const stereogrid::FrameResult& result{pipeline.process(recording->load(i))};
    for (const stereogrid::FrameStatus status : result.status) {  // conditions that limit the use of the grids
      std::printf("frame %zu: %s\n", i, names_of(status)[static_cast<std::size_t>(status)].data());
    }
    const auto cell{result.vehicle.geometry.cell_at({10, 0})};  // 10 m ahead
    const auto confirmed{std::ranges::count_if(result.obstacles, &stereogrid::Obstacle::confirmed)};
    std::printf("frame %zu: P(occupied) %.2f, %d confirmed obstacles\n", i,
                result.vehicle.occupancy(cell->ix, cell->iy), static_cast<int>(confirmed));
  }
}
