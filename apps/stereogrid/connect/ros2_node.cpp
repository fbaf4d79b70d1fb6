// SPDX-License-Identifier: Apache-2.0
#include "connect/ros2_node.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <filesystem>

#include "cli/program.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* file_name{"libstereogrid_dds.so"};
constexpr const char* variable{"STEREOGRID_DDS_LIBRARY"};
constexpr const char* what_to_install{
    "It comes with the package stereogrid-dds, or is built where Cyclone DDS is (Debian: cyclonedds-dev; "
    "docs/ros2.md)."};

void* opened(const std::string& name) {
  void* const library{dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)};
  if (library != nullptr) return library;
  const char* const problem{dlerror()};
  throw DeviceError{
      fmt::format("ROS 2: the library {} could not be loaded: {}. Is the package stereogrid-dds installed, "
                  "with Cyclone DDS (Debian: libddsc0debian)?",
                  io::printable(name), problem == nullptr ? "" : problem)};
}

void* found_and_opened() {
  if (const char* const named{std::getenv(variable)}; named != nullptr && *named != '\0') return opened(named);
  std::error_code error;
  const fs::path folder{fs::read_symlink("/proc/self/exe", error).parent_path()};
  const std::vector<fs::path> places{folder / file_name,
                                     folder / ".." / STEREOGRID_LIBRARY_FOLDER / "stereogrid" / file_name};
  for (const fs::path& place : places) {
    if (!folder.empty() && io::is_there(place)) return opened(place.string());
  }
  if (void* const library{dlopen(file_name, RTLD_NOW | RTLD_LOCAL)}; library != nullptr) return library;
  throw DeviceError{fmt::format("ROS 2: {} was not found, neither as {} nor {}, nor where libraries are. {}", file_name,
                                io::printable_path(places[0]), io::printable_path(places[1]), what_to_install)};
}

const dds::Library& load() {
  void* const library{found_and_opened()};  // it stays loaded: its threads may outlive what it made
  void* const symbol{dlsym(library, dds::library_function)};
  if (symbol != nullptr) {
    const dds::Library& found{*reinterpret_cast<const dds::Library* (*)()>(symbol)()};
    if (version() == found.version && found.sizes == dds::interface_sizes()) return found;
  }
  throw DeviceError{fmt::format(
      "ROS 2: {} belongs to another build than this stereogrid {}. Install both from the same.", file_name, version())};
}

dds::Distro distro_of(std::string name) {
  if (name.empty()) {
    const char* const installed{std::getenv("ROS_DISTRO")};
    name = installed == nullptr ? "" : installed;
  }
  if (name.empty()) return dds::Distro::automatic;
  const bool is_before_iron{name == "humble" || name == "galactic" || name == "foxy"};
  return is_before_iron ? dds::Distro::humble : dds::Distro::jazzy;
}

dds::NodeOptions node_options(const Ros2Options& options) {
  const std::vector<std::string>& frames{options.frames};
  if (!frames.empty() && (frames[0].empty() || frames[1].empty() || frames[0] == frames[1])) {
    throw ConfigError{"--ros2-frames: give two names that differ, such as odom,base_link."};
  }
  return {.name = options.node,
          .remappings = options.remappings,
          .left_out = options.leaves_tf ? std::vector<std::string>{"/tf"} : std::vector<std::string>{},
          .distro = distro_of(options.distro),
          .warn = [](const std::string& sentence) { spdlog::warn("{}", sentence); }};
}

}  // namespace

void add_ros2_options(Command command, Ros2Options& options) {
  command.add_option("--ros2-node NAME|NAMESPACE/NAME", options.node, "Name of the node, with its namespace.")
      .show_default();
  command.add_option("--ros2-remap FROM:=TO,...", options.remappings,
                     "Other names of topics in ROS 2: occupancy_grid:=/map; without a slash in front: below the node.");
  command.add_flag("--ros2-leave-tf", options.leaves_tf,
                   "Do not publish /tf, which the robot's own odometry publishes. Implied by poses from ROS 2.");
  command
      .add_option(
          "--ros2-frames WORLD,VEHICLE", options.frames,
          "Names of the frames in all messages: of the filtered grid, and of the vehicle (on the road below the "
          "left camera). Otherwise odom,base_link.")
      .expected(2);
  command
      .add_option(
          "--ros2-distro", options.distro,
          "Layout of ros_discovery_info, which ros2 node list reads; messages do not depend on it. Default: that of "
          "ROS_DISTRO, otherwise that of the peers (humble until one is seen). jazzy, kilted and lyrical share one.")
      .one_of({"humble", "jazzy", "kilted", "lyrical"});
}

void refuse_without_node(const Ros2Options& options) {
  if (options.publishes || options == Ros2Options{}) return;
  throw ConfigError{"The options --ros2-… are of a node of ROS 2, but there is none. Give --ros2, too."};
}

void check(const Ros2Options& options) {
  load().check(node_options(options));
}

std::shared_ptr<dds::Node> open_ros2_node(const Ros2Options& options) {
  static std::weak_ptr<dds::Node> last;  // commands open it on one thread
  std::shared_ptr<dds::Node> node{last.lock()};
  if (!node) last = node = load().open(node_options(options));
  return node;
}

}  // namespace stereogrid::app
