// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/mcap/writer.hpp"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>

#include "file.hpp"
#include "write/open_chunk.hpp"

namespace stereogrid::mcap {
namespace {

// together less than largest_chunk_bytes, the most that our reader takes
constexpr std::size_t largest_chunk_option{std::size_t{128} << 20};
constexpr std::size_t largest_message{std::size_t{256} << 20};

std::uint64_t apart(std::uint64_t a, std::uint64_t b) {
  return a > b ? a - b : b - a;
}

std::uint16_t next_id(std::uint16_t last) {
  if (last == std::numeric_limits<std::uint16_t>::max()) {
    throw std::length_error{"An MCAP file has no more than 65 535 schemas and as many channels."};
  }
  return static_cast<std::uint16_t>(last + 1);
}

}  // namespace

class Writer::Implementation {
 public:
  Implementation(const std::filesystem::path& path, const WriterOptions& options)
      : options_{checked(options)}, file_{path}, chunk_{options.compression} {
    Bytes bytes;
    put(bytes, view_of(magic));
    {
      const Record record{bytes, Op::header};
      put_text(bytes, options_.profile);
      put_text(bytes, options_.library);
    }
    file_.write(bytes);
  }

  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data) {
    require_open();
    const std::uint16_t id{next_id(summary_.schemas())};
    Bytes bytes;
    {
      const Record record{bytes, Op::schema};
      put(bytes, id);
      put_text(bytes, name);
      put_text(bytes, encoding);
      put_text(bytes, data);
    }
    // not in a chunk: a damaged one would take along what later ones need
    file_.write(bytes);
    summary_.add_schema(bytes);
    return id;
  }

  std::uint16_t add_channel(std::string_view topic, std::string_view message_encoding, std::uint16_t schema,
                            const std::map<std::string, std::string>& metadata) {
    require_open();
    if (schema > summary_.schemas()) throw std::invalid_argument{fmt::format("There is no schema {}.", schema)};
    const std::uint16_t id{next_id(summary_.channels())};
    Bytes bytes;
    {
      const Record record{bytes, Op::channel};
      put(bytes, id);
      put(bytes, schema);
      put_text(bytes, topic);
      put_text(bytes, message_encoding);
      put_texts(bytes, metadata);
    }
    file_.write(bytes);
    summary_.add_channel(bytes);
    chunk_.add_channel();
    return id;
  }

  void write(const Message& message) {
    require_open();
    if (message.channel == 0 || message.channel > summary_.channels()) {
      throw std::invalid_argument{fmt::format("There is no channel {}.", message.channel)};
    }
    if (message.data.size() > largest_message) throw std::length_error{"A message of more than 256 MiB."};
    if (!chunk_.empty() && apart(message.log_time_ns, chunk_.begin_ns()) >= options_.chunk_ns) flush();
    chunk_.add(message);
    if (chunk_.size() >= options_.chunk_bytes) flush();
  }

  void write_metadata(std::string_view name, const std::map<std::string, std::string>& metadata) {
    require_open();
    Bytes bytes;
    {
      const Record record{bytes, Op::metadata};
      put_text(bytes, name);
      put_texts(bytes, metadata);
    }
    const std::uint64_t offset{file_.size()};
    file_.write(bytes);
    summary_.add_metadata(offset, bytes.size(), name);
  }

  void flush() {
    require_open();
    if (chunk_.empty()) return;
    const OpenChunk::Packed packed{chunk_.pack(file_.size(), summary_)};
    file_.write(packed.head, packed.body, packed.body_crc, packed.message_indexes);
    chunk_.clear();
  }

  void close() {
    if (is_closed_) return;
    flush();
    is_closed_ = true;
    Bytes end;
    {
      const Record record{end, Op::data_end};
      put(end, file_.crc());
    }
    file_.write(end);
    file_.write(summary_.bytes(file_.size()));
    file_.close();
  }

 private:
  static const WriterOptions& checked(const WriterOptions& options) {
    if (options.chunk_bytes <= largest_chunk_option) return options;
    throw std::invalid_argument{"Chunks of more than 128 MiB: no reader would like them."};
  }

  void require_open() const {
    if (is_closed_) throw std::logic_error{"The MCAP file is closed already."};
    file_.require_writable();
  }

  WriterOptions options_;
  FileOutput file_;
  OpenChunk chunk_;
  Summary summary_;
  bool is_closed_{false};
};

Writer::Writer(const std::filesystem::path& path, const WriterOptions& options)
    : implementation_{std::make_unique<Implementation>(path, options)} {}

Writer::Writer(Writer&&) noexcept = default;

Writer::~Writer() {
  if (!implementation_) return;
  try {
    implementation_->close();
  } catch (const std::exception&) {  // call close() to receive errors
  }
}

std::uint16_t Writer::add_schema(std::string_view name, std::string_view encoding, std::string_view data) {
  return implementation_->add_schema(name, encoding, data);
}

std::uint16_t Writer::add_channel(std::string_view topic, std::string_view message_encoding, std::uint16_t schema,
                                  const std::map<std::string, std::string>& metadata) {
  return implementation_->add_channel(topic, message_encoding, schema, metadata);
}

void Writer::write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time_ns,
                   std::uint64_t publish_time_ns, std::span<const std::byte> data) {
  implementation_->write({channel, sequence, log_time_ns, publish_time_ns, data});
}

void Writer::write_metadata(std::string_view name, const std::map<std::string, std::string>& metadata) {
  implementation_->write_metadata(name, metadata);
}

void Writer::flush() {
  implementation_->flush();
}

void Writer::close() {
  implementation_->close();
}

std::string offered_qos_profiles(const OfferedQos& qos) {
  // numbers as in rmw's types.h; newer versions of rosbag2 write words, and read these, too
  constexpr std::string_view forever{"    sec: 9223372036\n    nsec: 854775807\n"};
  return fmt::format(
      "- history: 1\n  depth: {}\n  reliability: {}\n  durability: {}\n  deadline:\n{}  lifespan:\n{}  liveliness: 1\n"
      "  liveliness_lease_duration:\n{}  avoid_ros_namespace_conventions: false",
      qos.depth, qos.reliable ? 1 : 2, qos.transient_local ? 1 : 2, forever, forever, forever);
}

}  // namespace stereogrid::mcap
