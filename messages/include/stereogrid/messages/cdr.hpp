// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/messages/message.hpp"

// CDR as ROS 2 has it on the wire and in recordings (OMG DDS-XTypes, encoding version 1, plain, little-endian): four
// bytes 00 01 00 00, then the fields in order, each number at a multiple of its own size from behind these four.

namespace stereogrid::messages {

/// Turns messages into bytes. Its memory is used again, and arrays of numbers are copied in one piece.
class STEREOGRID_EXPORT CdrWriter {
 public:
  /// The bytes stay as they are until the next call. Throws InputError: a text or array of more than 2³² − 2 elements.
  template <Message M>
  std::span<const std::byte> encode(const M& message) {
    start();
    write(message);
    return bytes_;
  }

  template <class T>
  void operator()(std::string_view /*name*/, const T& field) {
    write(field);
  }

 private:
  void start();
  void append(const void* data, std::size_t bytes);
  void align(std::size_t alignment);
  void write_count(std::size_t count);
  void write(const std::string& text);

  template <Primitive T>
  void write(T number) {
    align(sizeof(T));
    append(&number, sizeof(T));
  }
  template <Message M>
  void write(const M& message) {
    message.visit_fields(*this);
  }
  template <class T, std::size_t n>
  void write(const std::array<T, n>& elements) {
    write_elements(std::span<const T>{elements});
  }
  template <class T>
  void write(const std::vector<T>& elements) {
    write_count(elements.size());
    write_elements(std::span<const T>{elements});
  }
  template <class T>
  void write_elements(std::span<const T> elements) {
    if constexpr (Primitive<T>) {
      if (elements.empty()) return;
      align(sizeof(T));
      append(elements.data(), elements.size_bytes());
    } else {
      for (const T& element : elements) write(element);
    }
  }

  std::vector<std::byte> bytes_;
};

/// Turns bytes into a message; see `decode`.
class STEREOGRID_EXPORT CdrReader {
 public:
  /// `type_name`: for what it complains of.
  CdrReader(std::span<const std::byte> cdr, std::string_view type_name);

  template <class T>
  void operator()(std::string_view name, T& field) {
    field_ = name;
    read(field);
  }
  /// Throws InputError where more is left than the three bytes that a sender may fill up with.
  void finish() const;

 private:
  [[noreturn]] void reject(const std::string& what) const;
  [[nodiscard]] std::size_t left() const { return body_.size() - position_; }
  void align(std::size_t alignment);
  void copy_to(void* data, std::size_t bytes);
  std::size_t read_count(std::size_t least_bytes_each);
  void read(bool& flag);
  void read(std::string& text);

  template <Primitive T>
  void read(T& number) {
    align(sizeof(T));
    copy_to(&number, sizeof(T));
  }
  template <Message M>
  void read(M& message) {
    message.visit_fields(*this);
  }
  template <class T, std::size_t n>
  void read(std::array<T, n>& elements) {
    read_elements(std::span<T>{elements});
  }
  template <class T>
  void read(std::vector<T>& elements) {
    elements.resize(read_count(least_bytes<T>()));
    read_elements(std::span<T>{elements});
  }
  template <class T>
  void read_elements(std::span<T> elements) {
    if constexpr (Primitive<T>) {
      if (elements.empty()) return;
      align(sizeof(T));
      copy_to(elements.data(), elements.size_bytes());
    } else {
      for (T& element : elements) read(element);
    }
  }

  /// Adds up the fewest bytes that fields take.
  struct LeastBytes {
    template <class T>
    void operator()(std::string_view /*name*/, const T& /*field*/) {
      sum += of(static_cast<const T*>(nullptr));
    }
    template <Primitive T>
    static std::size_t of(const T* /*type*/) {
      return sizeof(T);
    }
    static std::size_t of(const std::string* /*type*/) { return sizeof(std::uint32_t); }
    template <class T>
    static std::size_t of(const std::vector<T>* /*type*/) {
      return sizeof(std::uint32_t);
    }
    template <class T, std::size_t n>
    static std::size_t of(const std::array<T, n>* /*type*/) {
      return n * of(static_cast<const T*>(nullptr));
    }
    template <Message M>
    static std::size_t of(const M* /*type*/) {
      static const std::size_t bytes{[] {
        LeastBytes fields;
        const M message{};
        message.visit_fields(fields);
        return fields.sum;
      }()};
      return bytes;
    }
    std::size_t sum{0};
  };
  template <class T>
  static std::size_t least_bytes() {
    return LeastBytes::of(static_cast<const T*>(nullptr));
  }

  std::string_view type_name_;
  std::string_view field_;
  std::span<const std::byte> body_;  // behind the first four bytes
  std::size_t position_{0};
};

/// Decodes `cdr` into `message`, whose memory is reused. Safe for untrusted bytes: allocates at most a small multiple
/// of their size. Throws InputError: not such a message, truncated, or followed by more bytes; `message` is then partly
/// overwritten.
template <Message M>
void decode(std::span<const std::byte> cdr, M& message) {
  CdrReader reader{cdr, M::type_name};
  message.visit_fields(reader);
  reader.finish();
}

}  // namespace stereogrid::messages
