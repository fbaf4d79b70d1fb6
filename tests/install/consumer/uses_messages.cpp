// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <stereogrid/messages/cdr.hpp>
#include <stereogrid/messages/definition.hpp>
#include <stereogrid/messages/frame_messages.hpp>
#include <stereogrid/messages/nav_msgs.hpp>

#include <cstdio>

namespace messages = stereogrid::messages;

class Counter : public messages::Sink {
 public:
  std::uint32_t add(const messages::Channel& /*channel*/) override { return 0; }
  [[nodiscard]] bool wants(std::uint32_t /*channel*/) const override { return true; }
  void send(std::uint32_t /*channel*/, std::int64_t /*stamp_ns*/, std::span<const std::byte> /*cdr*/) override {
    ++count;
  }
  int count{0};
};

int main() {
  Counter counter;
  const stereogrid::Rig rig{200, 100, 100, 99.5, 49.5, 0.5};
  stereogrid::FrameResult result;
  result.vehicle.geometry = result.world.geometry = {0, -1, 1, 2, 2};
  for (auto* const layer : {&result.observed, &result.vehicle.occupancy, &result.world.occupancy, &result.world.moving,
                            &result.world.velocity_x, &result.world.velocity_y, &result.world.age_s}) {
    *layer = {2, 2};
  }
  messages::FrameMessages{counter, rig}.send(result, {});

  messages::nav_msgs::OccupancyGrid grid;
  grid.data = {100, -1};
  messages::CdrWriter writer;
  messages::nav_msgs::OccupancyGrid again;
  messages::decode(writer.encode(grid), again);
  std::printf("%d messages, and one read again:\n%s", counter.count,
              messages::definition_of<messages::nav_msgs::OccupancyGrid>().data());
  return counter.count > 8 && again.data == grid.data ? 0 : 1;
}
