// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/rosbag/rosbag.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {

/// A byte for the type, then a message. Its certainty is the message itself.
FUZZ_TARGET(bag_grid) {
  if (input.empty()) return;
  const std::span<const std::byte> cdr{std::as_bytes(input.subspan(1))};
  const bool has_cells{(input[0] & 1) != 0};
  accepts([&] {
    io::PlacedGrid grid{rosbag::decode_grid(
        cdr, has_cells ? messages::nav_msgs::GridCells::type_name : messages::nav_msgs::OccupancyGrid::type_name,
        "a grid")};
    accepts([&] { rosbag::set_certainty(grid, cdr, "a grid"); });
    const ObservedGrid made{io::resampled(grid, {0, -2, 0.5, 8, 8})};
    const auto is_share = [](float value) { return value >= 0 && value <= 1; };
    require(std::ranges::all_of(made.occupancy, is_share) && std::ranges::all_of(made.confidence, is_share),
            "a grid with values that are no probabilities");
  });
}

}  // namespace stereogrid::fuzz
