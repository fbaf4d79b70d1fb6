// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::app {

/// Nearest obstacles around the vehicle, as in MAVLink's message OBSTACLE_DISTANCE in the frame BODY_FRD.
struct ObstacleDistance {
  static constexpr std::uint16_t unknown{65535};  ///< the protocol's "unknown/not used"

  std::uint64_t time_us{0};
  /// Distances in sectors of 5°, cm. The first one is centred ahead, the others follow clockwise. max_cm + 1: no
  /// obstacle.
  std::array<std::uint16_t, 72> distances_cm{};
  std::uint16_t min_cm{0};
  std::uint16_t max_cm{0};
};

/// Sectors of a result. Obstacles are the occupied cells of the filtered grid, which has drops, too. A sector without
/// any is free if the scan sees all of it free, else unknown. Distances are relative to the vehicle frame.
[[nodiscard]] ObstacleDistance obstacle_distance_of(const FrameResult& result);

/// Packets of MAVLink 2 without a signature.
class MavlinkEncoder {
 public:
  [[nodiscard]] std::vector<std::uint8_t> heartbeat();
  [[nodiscard]] std::vector<std::uint8_t> encoded(const ObstacleDistance& message);

 private:
  [[nodiscard]] std::vector<std::uint8_t> packet(std::uint32_t id, std::uint8_t crc_extra,
                                                 std::vector<std::uint8_t> payload);

  std::uint8_t sequence_{0};
};

/// Sends OBSTACLE_DISTANCE by UDP, at most 15 a second of the frames' stamps, and a heartbeat once a second. Packets
/// without a receiver are lost.
class MavlinkSender {
 public:
  /// `address`: "HOST:PORT", "[IPV6]:PORT". Throws ConfigError: no address; DeviceError: no such host.
  explicit MavlinkSender(const std::string& address);
  MavlinkSender(const MavlinkSender&) = delete;
  MavlinkSender& operator=(const MavlinkSender&) = delete;
  ~MavlinkSender();

  void send(const FrameResult& result, std::int64_t stamp_ns);

 private:
  void send(const std::vector<std::uint8_t>& packet) const;

  int socket_{-1};
  MavlinkEncoder encoder_;
  std::optional<std::int64_t> sent_ns_{};
  std::optional<std::int64_t> heartbeat_ns_{};
};

}  // namespace stereogrid::app
