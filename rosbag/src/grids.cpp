// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "images.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::rosbag {
namespace {

using messages::geometry_msgs::Quaternion;
using messages::nav_msgs::GridCells;
using messages::nav_msgs::OccupancyGrid;

constexpr float confidence_of_binary{0.9F};  // no topic has the certainty of the cells
constexpr std::uint64_t most_cells{4'000'000};
constexpr const char* certainty{"_certainty"};
constexpr const char* mend{"Correct what publishes it, or leave --fuse out."};

/// Place and heading of a grid's corner in its frame. A quaternion of zeros counts as none. Throws InputError.
Pose2 corner_of(const messages::geometry_msgs::Pose& origin, const std::string& name) {
  constexpr double level{0.99};  // vertical component of its z axis
  const Quaternion& q{origin.orientation};
  const bool is_unset{q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0};
  const auto unit{is_unset ? std::optional{std::array{0.0, 0.0, 0.0, 1.0}} : io::unit_quaternion({q.x, q.y, q.z, q.w})};
  const auto& p{origin.position};
  if (!unit || !std::isfinite(p.x) || !std::isfinite(p.y)) throw InputError{name, "has an invalid origin.", mend};
  const auto& [x, y, z, w]{*unit};
  if (1 - 2 * (x * x + y * y) < level) throw InputError{name, "is not level: its origin is tilted.", mend};
  return {p.x, p.y, std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))};
}

io::PlacedGrid grid_of(const OccupancyGrid& message, const std::string& name) {
  const auto& info{message.info};
  const std::uint64_t cells{static_cast<std::uint64_t>(info.width) * info.height};
  if (cells == 0 || cells != message.data.size() || cells > most_cells) {
    throw InputError{name,
                     fmt::format("has {} × {} cells and {} values (allowed 1 … {}).", info.width, info.height,
                                 message.data.size(), most_cells),
                     mend};
  }
  if (!(info.resolution > 0) || !std::isfinite(info.resolution)) {
    throw InputError{name, fmt::format("has a cell size of {} m.", info.resolution), mend};
  }
  const int nx{static_cast<int>(info.width)};
  const int ny{static_cast<int>(info.height)};
  io::PlacedGrid grid{
      {{0, 0, static_cast<double>(info.resolution), nx, ny}, Image<float>{nx, ny}, Image<float>{nx, ny}},
      corner_of(info.origin, name)};
  for (std::size_t i{0}; i < message.data.size(); ++i) {
    const int percent{message.data[i]};
    const bool is_known{percent >= 0 && percent <= 100};
    grid.cells.occupancy.data()[i] = is_known ? static_cast<float>(percent) / 100 : 0.5F;
    grid.cells.confidence.data()[i] = is_known ? confidence_of_binary : 0;
  }
  return grid;
}

/// The grid around the occupied cells, which are all that the message has: others are unknown.
io::PlacedGrid grid_of(const GridCells& message, const std::string& name) {
  constexpr float square{0.01F};
  const double size_m{static_cast<double>(message.cell_width)};
  if (!(size_m > 0) || !std::isfinite(size_m) || !(std::abs(message.cell_height / message.cell_width - 1) <= square)) {
    throw InputError{
        name, fmt::format("has cells of {} × {} m (allowed: squares).", message.cell_width, message.cell_height), mend};
  }
  constexpr double none{std::numeric_limits<double>::infinity()};
  Point2 least{none, none};
  Point2 largest{-none, -none};
  for (const auto& cell : message.cells) {
    if (!std::isfinite(cell.x) || !std::isfinite(cell.y))
      throw InputError{name, "has cells that are not finite.", mend};
    least = {std::min(least.x, cell.x), std::min(least.y, cell.y)};
    largest = {std::max(largest.x, cell.x), std::max(largest.y, cell.y)};
  }
  io::PlacedGrid grid;
  if (message.cells.empty()) return grid;
  const double columns{std::round((largest.x - least.x) / size_m) + 1};
  const double rows{std::round((largest.y - least.y) / size_m) + 1};
  if (!(columns * rows <= static_cast<double>(most_cells))) {
    throw InputError{name, fmt::format("spans {:.0f} × {:.0f} cells (allowed {} in all).", columns, rows, most_cells),
                     mend};
  }
  const int nx{static_cast<int>(columns)};
  const int ny{static_cast<int>(rows)};
  grid.cells = {{-size_m / 2, -size_m / 2, size_m, nx, ny}, Image<float>{nx, ny}, Image<float>{nx, ny}};
  grid.cells.occupancy.fill(0.5F);
  for (const auto& cell : message.cells) {
    const int ix{std::min(nx - 1, static_cast<int>(std::round((cell.x - least.x) / size_m)))};
    const int iy{std::min(ny - 1, static_cast<int>(std::round((cell.y - least.y) / size_m)))};
    grid.cells.occupancy(ix, iy) = 1;
    grid.cells.confidence(ix, iy) = confidence_of_binary;
  }
  grid.vehicle_from_grid = {least.x, least.y, 0};
  return grid;
}

bool has_grids(const mcap::Topic& topic) {
  return topic.message_count > 0 && (topic.type == OccupancyGrid::type_name || topic.type == GridCells::type_name);
}

}  // namespace

GridTopics choose_grid_topics(const std::vector<mcap::Topic>& topics, const std::string& asked) {
  std::vector<std::string> found;
  for (const mcap::Topic& topic : topics) {
    if (has_grids(topic) && !topic.name.ends_with(certainty)) found.push_back(topic.name);
  }
  GridTopics chosen;
  const std::string list{fmt::format("{}", fmt::join(found, ", "))};
  if (!asked.empty()) {
    if (std::ranges::find(found, asked) == found.end()) {
      chosen.reason = fmt::format("has no grids on {} (nav_msgs/OccupancyGrid or GridCells on: {})",
                                  io::printable(asked), found.empty() ? "none" : io::printable(list));
      return chosen;
    }
    found = {asked};
  }
  if (found.size() > 1) {
    std::vector<std::string> named(found);
    std::erase_if(named, [](const std::string& name) { return name.find("occupancy") == std::string::npos; });
    if (!named.empty()) found = std::move(named);
  }
  if (found.size() != 1) {
    chosen.reason = found.empty() ? "has no topic of nav_msgs/OccupancyGrid or GridCells"
                                  : fmt::format("has grids on more than one topic ({}); name one with --grid-topic",
                                                io::printable(list));
    return chosen;
  }
  chosen.cells = found.front();
  const mcap::Topic* const graded{find_topic(topics, chosen.cells + certainty)};
  if (graded != nullptr && graded->type == OccupancyGrid::type_name) chosen.certainty = graded->name;
  return chosen;
}

std::string frame_id_of(std::span<const std::byte> cdr) {
  messages::std_msgs::Header header;
  messages::CdrReader reader{cdr, messages::std_msgs::Header::type_name};
  reader("header", header);
  return header.frame_id;
}

io::PlacedGrid decode_grid(std::span<const std::byte> cdr, std::string_view type, const std::string& name) {
  if (type == GridCells::type_name) {
    GridCells message;
    messages::decode(cdr, message);
    return grid_of(message, name);
  }
  OccupancyGrid message;
  messages::decode(cdr, message);
  return grid_of(message, name);
}

void set_certainty(io::PlacedGrid& grid, std::span<const std::byte> cdr, const std::string& name) {
  OccupancyGrid message;
  messages::decode(cdr, message);
  const GridGeometry& geometry{grid.cells.geometry};
  if (message.info.width != static_cast<std::uint32_t>(geometry.nx) ||
      message.info.height != static_cast<std::uint32_t>(geometry.ny) ||
      message.data.size() != grid.cells.confidence.size()) {
    throw InputError{name, "has another size than the grid whose certainty it is.", mend};
  }
  for (std::size_t i{0}; i < message.data.size(); ++i) {
    const float share{static_cast<float>(std::clamp<int>(message.data[i], 0, 100)) / 100};
    float& confidence{grid.cells.confidence.data()[i]};
    confidence = confidence > 0 ? share : 0;
  }
}

std::string frame_of_first(const mcap::Bag& bag, const std::string& topic) {
  const auto cursor{bag.messages({.topics = {topic}})};
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      return frame_id_of(message->data);
    } catch (const InputError&) {
      continue;
    }
  }
  return {};
}

void find_grids(io::ForeignRecording& found, BagImages& images, const mcap::Bag& bag, const std::string& asked,
                const std::string& camera_frame, const std::string& world_frame) {
  BagGrids grids{choose_grid_topics(bag.topics(), asked), {}};
  found.why_no_grids = grids.topics.reason;
  if (grids.topics.cells.empty()) return;
  grids.cells = find_shots(bag, grids.topics.cells).shots;
  if (!grids.topics.certainty.empty()) grids.certainty = find_shots(bag, grids.topics.certainty).shots;
  found.grids_source = io::printable(grids.topics.cells);
  if (!grids.certainty.empty()) found.grids_source += " with " + io::printable(grids.topics.certainty);
  const std::string frame{frame_of_first(bag, grids.topics.cells)};
  TransformBuffer transforms;
  add_static_transforms(transforms, bag);
  const bool is_of_image{frame == camera_frame};  // the axes are a body's all the same
  const auto camera{is_of_image ? std::nullopt : camera_in_vehicle(transforms, frame, camera_frame)};
  grids.is_in_world = !camera && !frame.empty() && frame == world_frame && found.poses.size() > 1;
  if (!grids.is_in_world) {
    const Pose2 place{found.calibration ? camera_place(found.calibration->rig) : Pose2{}};
    grids.base_from_grid = place * (camera ? inverse(*camera) : Pose2{});
  }
  if (const bool is_fixed{frame == "map" || frame == "odom" || frame == world_frame};
      is_fixed && !camera && !grids.is_in_world) {
    found.grids_source.clear();
    found.why_no_grids = fmt::format("has grids in '{}' on {}, but no poses in that frame", io::printable(frame, 60),
                                     io::printable(grids.topics.cells));
    return;
  }
  found.grids_source += fmt::format(" in '{}'", io::printable(frame, 60));
  if (!camera && !grids.is_in_world) {
    found.grids_source += ", taken as that of the point below the left camera, x ahead";
    if (!is_of_image)
      found.grids_source += fmt::format("; /tf_static does not connect it with '{}'", io::printable(camera_frame, 60));
  }
  images.set_grids(std::move(grids));
}

}  // namespace stereogrid::rosbag
