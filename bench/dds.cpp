// SPDX-License-Identifier: Apache-2.0
//
// One end of what dds.py measures, by libstereogrid_dds.so:
// bench_dds LIBRARY send TOPIC CELLS HZ SECONDS: "grid STAMP", ns, for grids of CELLS × CELLS, stamped when they are
// sent; on /map latched.
// bench_dds LIBRARY receive NAMESPACE SECONDS: "image STAMP at NOW", ns, for each image of both cameras.
#include <dlfcn.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include "stereogrid/dds/node.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/definition.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace {

using namespace stereogrid;
using messages::nav_msgs::OccupancyGrid;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::chrono::duration<double> seconds(const char* text) {
  return std::chrono::duration<double>{std::atof(text)};
}

void send(dds::Node& node, char** argv) {
  OccupancyGrid grid;
  grid.info.width = grid.info.height = static_cast<std::uint32_t>(std::atoi(argv[4]));
  grid.data.assign(std::size_t{grid.info.width} * grid.info.height, 50);
  const std::uint32_t channel{
      node.sink().add({argv[3], OccupancyGrid::type_name, messages::definition_of<OccupancyGrid>(),
                       std::string_view{argv[3]} == "/map"})};
  std::this_thread::sleep_for(std::chrono::seconds{1});  // to be found
  messages::CdrWriter writer;
  const double hz{std::atof(argv[5])};
  const int count{static_cast<int>(hz * std::atof(argv[6]))};
  for (int i{0}; i < count; ++i) {
    std::this_thread::sleep_for(std::chrono::duration<double>{1 / hz});
    const std::int64_t stamp_ns{now_ns()};
    grid.header.stamp = {static_cast<std::int32_t>(stamp_ns / 1'000'000'000),
                         static_cast<std::uint32_t>(stamp_ns % 1'000'000'000)};
    node.sink().send(channel, stamp_ns, writer.encode(grid));
    std::cout << "grid " << stamp_ns << std::endl;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds{200});
}

void receive(dds::Node& node, char** argv) {
  for (const char* side : {"/left", "/right"}) {
    node.subscribe(std::string{argv[3]} + side + "/image_rect", std::string{messages::sensor_msgs::Image::type_name}, 5,
                   [](std::span<const std::byte> cdr) {
                     const std::int64_t at_ns{now_ns()};
                     messages::CdrReader reader{cdr, messages::sensor_msgs::Image::type_name};
                     messages::std_msgs::Header header;
                     reader("header", header);
                     std::cout << "image " << header.stamp.sec * 1'000'000'000LL + header.stamp.nanosec << " at "
                               << at_ns << '\n';
                   });
  }
  std::this_thread::sleep_for(seconds(argv[4]));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what{argc > 2 ? argv[2] : ""};
  void* const library{argc > 1 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : nullptr};
  void* const symbol{library == nullptr ? nullptr : dlsym(library, dds::library_function)};
  if (symbol == nullptr || (what == "send" && argc != 7) || (what == "receive" && argc != 5)) return 1;
  const auto node{reinterpret_cast<const dds::Library* (*)()>(symbol)()->open({.name = "bench_" + what})};
  if (what == "send") send(*node, argv);
  if (what == "receive") receive(*node, argv);
}
