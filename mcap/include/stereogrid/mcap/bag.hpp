// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/mcap/records.hpp"

namespace stereogrid::mcap {

/// Messages of one type under one name, from any publisher.
struct Topic {
  std::string name;
  std::string type;                  ///< "sensor_msgs/msg/Image"
  std::string message_encoding;      ///< "cdr"
  std::string offered_qos_profiles;  ///< QoS of the first publisher; empty: not recorded
  std::string schema_encoding;       ///< empty: the recording does not describe the type
  std::string schema;
  std::uint64_t message_count{0};
};

/// A ROS 2 recording: an MCAP file, a .db3 file of rosbag2, or a folder of several with rosbag2's metadata.yaml.
class STEREOGRID_EXPORT Bag {
 public:
  Bag() = default;
  Bag(const Bag&) = delete;
  Bag& operator=(const Bag&) = delete;
  virtual ~Bag() = default;

  [[nodiscard]] virtual const std::vector<Topic>& topics() const = 0;
  /// When the first and the last message were recorded; 0: there is none.
  [[nodiscard]] virtual std::uint64_t first_ns() const = 0;
  [[nodiscard]] virtual std::uint64_t last_ns() const = 0;
  /// In the order of their log times. The bag has to live as long. Throws InputError and DeviceError (the disk),
  /// while reading, too.
  [[nodiscard]] virtual std::unique_ptr<MessageCursor> messages(const Selection& selection) const = 0;
  /// Damage found so far, as messages that name the file.
  [[nodiscard]] virtual std::vector<std::string> damage() const = 0;
};

/// Recognised by content, not by name. Messages compressed one by one are unpacked as they are read; files compressed
/// as a whole (rosbag2's compression mode "file", zstd) are unpacked first, into the folder of temporary files. Throws
/// InputError: no recording; DeviceError: no space.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<Bag> open_bag(const std::filesystem::path& path);

}  // namespace stereogrid::mcap
