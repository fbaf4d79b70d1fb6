// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "format.hpp"

namespace stereogrid::mcap {

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_{descriptor} {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { close(); }

  [[nodiscard]] int get() const { return descriptor_; }
  /// errno, 0: closed. Network file systems report a full disk only here.
  int close();

 private:
  int descriptor_;
};

/// A file that only grows. Every function throws DeviceError; after the first the file stays as it is, and every later
/// call throws the same.
class FileOutput {
 public:
  explicit FileOutput(const std::filesystem::path& path);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// CRC-32 of all that was written.
  [[nodiscard]] std::uint32_t crc() const { return crc_; }

  void require_writable() const;
  void write(View bytes);
  /// In one go, so that the file ends before `head` or after `tail`, unless the system itself dies. `body_crc`: the
  /// CRC-32 of `body`, which need not be found again.
  void write(View head, View body, std::uint32_t body_crc, View tail);
  void close();

 private:
  [[noreturn]] void fail(int error_number);
  void write_whole(View head, View body, View tail);

  Descriptor file_;
  std::string name_;
  std::string error_text_;  // empty: none yet
  std::uint64_t size_{0};
  std::uint32_t crc_{0};
};

/// A file on a disk, whose length at its opening counts.
class FileInput {
 public:
  /// Throws InputError: no such file, no permission, no regular file; DeviceError: other failures.
  explicit FileInput(const std::filesystem::path& path);

  /// Printable.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Fills `bytes`, which must lie within the file. Throws DeviceError: the disk, or the file was cut off meanwhile.
  void read(std::uint64_t at, std::span<std::byte> bytes) const;
  /// `size` bytes. Throws DeviceError as read(), Malformed where the file does not reach so far.
  void read(std::uint64_t at, std::uint64_t size, Bytes& out) const;

 private:
  [[noreturn]] void fail_to_open(int error_number) const;

  Descriptor file_;
  std::string name_;
  std::uint64_t size_{0};
};

}  // namespace stereogrid::mcap
