// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"

namespace stereogrid::mcap {

enum class Compression { none, lz4, zstd };

struct WriterOptions {
  Compression compression{Compression::zstd};
  std::size_t chunk_bytes{std::size_t{1} << 20};  ///< size of the messages at which a chunk is written
  std::uint64_t chunk_ns{1'000'000'000};          ///< maximum difference of log times within a chunk
  std::string profile{"ros2"};
  std::string library{"stereogrid"};  ///< program that wrote the file
};

/// Writes an MCAP file from its beginning to its end; a file of this name is replaced. Messages are gathered in chunks,
/// and a chunk is written whole: if the program dies, the file has all but the messages of the last chunk
/// (WriterOptions), and is read as a stream. Call flush() where no message comes for a while. What the system has
/// written, a loss of power may take away all the same.
///
/// Memory: two buffers of a chunk's size, the times of its messages, 100 bytes or so for each chunk of the file. A
/// message allocates nothing once they have grown.
///
/// Every function throws DeviceError where the file cannot be written, as on a full disk. The file then ends with the
/// last whole record, and whatever is written later throws the same again.
class STEREOGRID_EXPORT Writer {
 public:
  explicit Writer(const std::filesystem::path& path, const WriterOptions& options = {});
  Writer(Writer&&) noexcept;
  /// Closes the file; an error is lost. Call close() to see it.
  ~Writer();

  /// The id of a new schema. Throws std::length_error: there are 65 535 already, or a text is longer than 4 GB.
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);

  /// The id of a new channel. `schema` 0: none. For profile "ros2" `metadata` has "offered_qos_profiles"
  /// (offered_qos_profiles()). Throws std::invalid_argument where there is no such schema; std::length_error.
  std::uint16_t add_channel(std::string_view topic, std::string_view message_encoding, std::uint16_t schema,
                            const std::map<std::string, std::string>& metadata);

  /// Throws std::invalid_argument where there is no such channel; std::length_error for more than 256 MiB.
  void write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time_ns, std::uint64_t publish_time_ns,
             std::span<const std::byte> data);

  /// Writes a metadata record.
  void write_metadata(std::string_view name, const std::map<std::string, std::string>& metadata);

  /// Writes the chunk as it is now, so that a crash loses none of it.
  void flush();

  /// Writes the last chunk and the summary that files are opened fast by. Nothing can be written afterwards.
  void close();

 private:
  class STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// QoS of a ROS 2 publisher.
struct OfferedQos {
  int depth{10};
  bool reliable{true};
  bool transient_local{false};
};

/// As rosbag2 writes it into a channel's metadata (and a topic's row of a .db3), in the form that all its versions
/// read.
[[nodiscard]] STEREOGRID_EXPORT std::string offered_qos_profiles(const OfferedQos& qos);

}  // namespace stereogrid::mcap
