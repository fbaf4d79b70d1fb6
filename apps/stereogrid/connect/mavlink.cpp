// SPDX-License-Identifier: Apache-2.0
#include "connect/mavlink.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/occupancy_values.hpp"

namespace stereogrid::app {
namespace {

constexpr int sectors{72};
constexpr double sector_rad{2 * std::numbers::pi / sectors};
constexpr std::int64_t period_ns{1'000'000'000 / 15};
constexpr std::int64_t heartbeat_period_ns{1'000'000'000};

// Message of common.xml: id, and the byte that its definition adds to the checksum.
struct Definition {
  std::uint32_t id;
  std::uint8_t crc_extra;
};
constexpr Definition heartbeat_definition{0, 50};
constexpr Definition distance_definition{330, 23};

// enumerations of common.xml
constexpr std::uint8_t onboard_controller{18};
constexpr std::uint8_t no_autopilot{8};
constexpr std::uint8_t active{4};
constexpr std::uint8_t mavlink_version{3};
constexpr std::uint8_t start{0xfd};  // first byte of a packet of MAVLink 2
constexpr std::uint8_t unknown_sensor{4};
constexpr std::uint8_t body_frd{12};
constexpr std::uint8_t system_id{1};       // the autopilot's
constexpr std::uint8_t component_id{196};  // obstacle avoidance

/// Little-endian, as the protocol has it.
class Payload {
 public:
  template <class T>
  Payload& operator<<(T value) {
    static_assert(std::endian::native == std::endian::little);
    const auto* const bytes{reinterpret_cast<const std::uint8_t*>(&value)};
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
    return *this;
  }
  [[nodiscard]] std::vector<std::uint8_t> bytes() && { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

// CRC-16/MCRF4XX.
std::uint16_t checksum(const std::vector<std::uint8_t>& bytes, std::size_t first, std::uint8_t extra) {
  std::uint16_t crc{0xffff};
  const auto add = [&crc](std::uint8_t byte) {
    auto low{static_cast<std::uint8_t>(byte ^ (crc & 0xff))};
    low = static_cast<std::uint8_t>(low ^ (low << 4));
    crc = static_cast<std::uint16_t>((crc >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4));
  };
  std::for_each(bytes.begin() + static_cast<std::ptrdiff_t>(first), bytes.end(), add);
  add(extra);
  return crc;
}

std::uint16_t centimetres(double value_m) {
  return static_cast<std::uint16_t>(std::clamp(std::floor(100 * value_m), 0.0, 65533.0));
}

/// Sector of a bearing (counter-clockwise): 0 is centred ahead, the others follow clockwise.
int sector_of(double bearing_rad) {
  const int sector{static_cast<int>(std::lround(-bearing_rad / sector_rad))};
  return (sector % sectors + sectors) % sectors;
}

/// Distance of the nearest point of a cell, and the sectors that it touches.
template <class Visit>
void visit_sectors(const GridGeometry& grid, int ix, int iy, Visit&& visit) {
  const double half_m{grid.cell_size_m / 2};
  const Point2 centre{grid.centre(ix, iy)};
  const double near_x_m{std::max(0.0, std::abs(centre.x) - half_m)};
  const double near_y_m{std::max(0.0, std::abs(centre.y) - half_m)};
  const double bearing_rad{std::atan2(centre.y, centre.x)};
  double first_rad{0};  // bearings of the corners, relative to that of the centre
  double last_rad{0};
  for (const double dx_m : {-half_m, half_m}) {
    for (const double dy_m : {-half_m, half_m}) {
      const double corner_rad{std::atan2(centre.y + dy_m, centre.x + dx_m)};
      const double offset_rad{std::remainder(corner_rad - bearing_rad, 2 * std::numbers::pi)};
      first_rad = std::min(first_rad, offset_rad);
      last_rad = std::max(last_rad, offset_rad);
    }
  }
  const double distance_m{std::hypot(near_x_m, near_y_m)};
  for (double offset_rad{first_rad}; offset_rad < last_rad; offset_rad += sector_rad / 2) {
    visit(sector_of(bearing_rad + offset_rad), distance_m);
  }
  visit(sector_of(bearing_rad + last_rad), distance_m);
}

/// True for sectors that beams of the scan see free over their whole width.
std::array<bool, sectors> free_sectors(const messages::sensor_msgs::LaserScan& scan) {
  std::array<bool, sectors> are_free{};
  for (int sector{0}; sector < sectors; ++sector) {
    const double first_rad{-sector * sector_rad - sector_rad / 2 - static_cast<double>(scan.angle_min)};
    const double turns{std::floor(first_rad / (2 * std::numbers::pi))};
    const double first{(first_rad - 2 * std::numbers::pi * turns) / static_cast<double>(scan.angle_increment)};
    const double last{first + sector_rad / static_cast<double>(scan.angle_increment)};
    const std::size_t beams{scan.ranges.size() - 1};  // from edge to edge
    const bool is_whole_turn{static_cast<double>(scan.angle_max - scan.angle_min) > 2 * std::numbers::pi - 1e-5};
    if (last > static_cast<double>(beams) && !is_whole_turn) continue;
    bool is_free{true};
    for (auto beam = static_cast<std::size_t>(first); beam < static_cast<std::size_t>(std::ceil(last)) + 1; ++beam)
      is_free = is_free && scan.ranges[is_whole_turn ? beam % beams : beam] == std::numeric_limits<float>::infinity();
    are_free.at(static_cast<std::size_t>(sector)) = is_free;
  }
  return are_free;
}

}  // namespace

ObstacleDistance obstacle_distance_of(const FrameResult& result) {
  const GridLayers& grid{result.vehicle};
  messages::sensor_msgs::LaserScan scan;
  messages::fill(scan, rigs_of(result), grid.geometry, grid.occupancy.view());
  ObstacleDistance message{.min_cm = centimetres(static_cast<double>(scan.range_min)),
                           .max_cm = centimetres(static_cast<double>(scan.range_max))};
  const std::array<bool, sectors> are_free{free_sectors(scan)};
  for (std::size_t i{0}; i < are_free.size(); ++i) {
    message.distances_cm[i] = are_free[i] ? static_cast<std::uint16_t>(message.max_cm + 1) : ObstacleDistance::unknown;
  }
  for (int iy{0}; iy < grid.geometry.ny; ++iy) {
    for (int ix{0}; ix < grid.geometry.nx; ++ix) {
      if (occupancy_value(grid.occupancy(ix, iy), OccupancyScale::trinary) != 100) continue;
      visit_sectors(grid.geometry, ix, iy, [&message](int sector, double distance_m) {
        std::uint16_t& nearest{message.distances_cm.at(static_cast<std::size_t>(sector))};
        const std::uint16_t found{std::max(centimetres(distance_m), message.min_cm)};
        if (found <= message.max_cm) nearest = std::min(nearest, found);
      });
    }
  }
  return message;
}

std::vector<std::uint8_t> MavlinkEncoder::heartbeat() {
  Payload payload;
  payload << std::uint32_t{0} << onboard_controller << no_autopilot << std::uint8_t{0} << active << mavlink_version;
  return packet(heartbeat_definition.id, heartbeat_definition.crc_extra, std::move(payload).bytes());
}

// The fields of the definition by descending size, then its extensions.
std::vector<std::uint8_t> MavlinkEncoder::encoded(const ObstacleDistance& message) {
  constexpr std::uint8_t increment_deg{360 / sectors};
  Payload payload;
  payload << message.time_us;
  for (const std::uint16_t distance_cm : message.distances_cm) payload << distance_cm;
  payload << message.min_cm << message.max_cm << unknown_sensor << increment_deg << float{increment_deg} << float{0}
          << body_frd;
  return packet(distance_definition.id, distance_definition.crc_extra, std::move(payload).bytes());
}

std::vector<std::uint8_t> MavlinkEncoder::packet(std::uint32_t id, std::uint8_t crc_extra,
                                                 std::vector<std::uint8_t> payload) {
  while (payload.size() > 1 && payload.back() == 0) payload.pop_back();  // the protocol truncates them
  const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value & 0xff); };
  const auto size{static_cast<std::uint32_t>(payload.size())};
  std::vector<std::uint8_t> bytes{start,         byte(size),    0, 0, sequence_++, system_id, component_id, byte(id),
                                  byte(id >> 8), byte(id >> 16)};
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  const std::uint16_t crc{checksum(bytes, 1, crc_extra)};
  bytes.push_back(byte(crc));
  bytes.push_back(byte(std::uint32_t{crc} >> 8));
  return bytes;
}

MavlinkSender::MavlinkSender(const std::string& address) {
  const std::size_t colon{address.rfind(':')};
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
    throw ConfigError{fmt::format("--mavlink {}: give HOST:PORT, such as 127.0.0.1:14540.", io::printable(address))};
  }
  std::string host{address.substr(0, colon)};
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found{nullptr};
  const int error{getaddrinfo(host.c_str(), address.c_str() + colon + 1, &hints, &found)};
  if (error != 0) {
    throw DeviceError{
        fmt::format("--mavlink {}: {}. Give HOST:PORT.", io::printable(address), io::printable(gai_strerror(error)))};
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses{found, freeaddrinfo};
  socket_ = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0 || connect(socket_, found->ai_addr, found->ai_addrlen) != 0) {
    if (socket_ >= 0) close(socket_);
    throw DeviceError{fmt::format("--mavlink {}: {}.", io::printable(address), std::strerror(errno))};
  }
}

MavlinkSender::~MavlinkSender() {
  if (socket_ >= 0) close(socket_);
}

void MavlinkSender::send(const FrameResult& result, std::int64_t stamp_ns) {
  const auto is_due = [stamp_ns](std::optional<std::int64_t>& last_ns, std::int64_t after_ns) {
    if (last_ns && stamp_ns >= *last_ns && stamp_ns - *last_ns < after_ns) return false;
    last_ns = stamp_ns;
    return true;
  };
  if (is_due(heartbeat_ns_, heartbeat_period_ns)) send(encoder_.heartbeat());
  if (!is_due(sent_ns_, period_ns)) return;
  ObstacleDistance message{obstacle_distance_of(result)};
  message.time_us = static_cast<std::uint64_t>(std::max<std::int64_t>(stamp_ns, 0)) / 1000;
  send(encoder_.encoded(message));
}

void MavlinkSender::send(const std::vector<std::uint8_t>& packet) const {
  static_cast<void>(::send(socket_, packet.data(), packet.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
}

}  // namespace stereogrid::app
