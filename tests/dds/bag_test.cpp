// SPDX-License-Identifier: Apache-2.0
//
// A bag that is played to the network and recorded at the same time: both are the same.
#include "stereogrid/mcap/bag.hpp"
#include "../app/bags/bag_drive.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using dds::testing::bare_peer;
using dds::testing::Peer;

/// As bare_peer prints it.
std::string line_of(const messages::nav_msgs::OccupancyGrid& grid) {
  std::uint32_t sum{0};
  for (std::size_t i{0}; i < grid.data.size(); ++i) {
    sum += static_cast<std::uint32_t>(i + 1) * static_cast<std::uint32_t>(grid.data[i]);
  }
  std::ostringstream line;
  const auto& origin{grid.info.origin};
  line << "grid " << grid.header.stamp.sec * std::int64_t{1'000'000'000} + grid.header.stamp.nanosec << ' '
       << grid.header.frame_id << ' ' << grid.info.width << 'x' << grid.info.height << ' ' << grid.info.resolution
       << ' ' << origin.position.x << ' ' << origin.position.y << ' ' << origin.orientation.w << " sum " << sum;
  return line.str();
}

TEST_F(Bags, PlayedToTheNetworkIsWhatIsRecorded) {
  write_mcap(bag(), entries({}));
  const fs::path recording{*folder / "recording.mcap"};
  Peer map{bare_peer("grids rt/stereo_grid/occupancy_grid reliable transient_local 8 40")};
  Peer live{"exec timeout --foreground -s INT 5 " STEREOGRID_TOOL " live " + bag().string() +
            " --poses none --loop --ros2 --listen :0 --mcap " + recording.string() + " 2>&1"};
  std::vector<std::string> came{map.rest()};
  live.rest();

  std::vector<std::string> recorded;
  const auto bag_of_results{mcap::open_bag(recording)};
  const auto cursor{bag_of_results->messages({.topics = {"/stereo_grid/occupancy_grid"}})};
  while (const mcap::Message* const message{cursor->next()}) {
    messages::nav_msgs::OccupancyGrid grid;
    messages::decode(message->data, grid);
    recorded.push_back(line_of(grid));
  }
  ASSERT_THAT(came, SizeIs(8));
  for (const std::string& grid : came) EXPECT_THAT(recorded, Contains(grid.substr(0, grid.find(" at "))));
}

}  // namespace
}  // namespace stereogrid::app::testing
