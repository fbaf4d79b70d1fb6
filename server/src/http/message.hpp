// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace stereogrid::server {

/// Evaluated parts of an HTTP request; a header that is not there is empty.
struct HttpRequest {
  std::string method;
  std::string target;
  std::string host;  ///< empty also where there are several
  std::string origin;
  std::string authorization;
  std::string cookie;
  std::string range;
  std::string if_range;
  std::string if_none_match;
  std::string subprotocols;  ///< Sec-WebSocket-Protocol, all of them
  bool has_body{false};
};

/// Target of a request, decoded.
struct Target {
  std::string path;  ///< from "/"; no empty segment but a last one, no "." or "..", no control character
  std::vector<std::pair<std::string, std::string>> query;

  /// The first of that name; none: there is no such.
  [[nodiscard]] const std::string* find(std::string_view name) const;
};

/// Parses the target of a request line, such as /a%20b?token=x. None: it is malformed, or means something outside.
[[nodiscard]] std::optional<Target> parse_target(std::string_view text);

struct ByteRange {
  std::uint64_t begin;
  std::uint64_t end;  ///< one past the last; begin == end: nothing of the file is in the range
};

/// The range of a header Range (RFC 9110, 14.2). None: there is none, several, or one that is not understood, so that
/// all is sent.
[[nodiscard]] std::optional<ByteRange> parse_range(std::string_view header, std::uint64_t size);

/// Whether a header If-None-Match names it.
[[nodiscard]] bool matches_etag(std::string_view header, std::string_view etag);

/// An open file descriptor; below 0: none.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_{descriptor} {}
  Descriptor(Descriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  [[nodiscard]] int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

/// Bytes [begin, end) of an open file.
struct FilePart {
  std::shared_ptr<const Descriptor> file;
  std::uint64_t begin;
  std::uint64_t end;
};

using Body = std::variant<std::string, std::shared_ptr<const std::string>, FilePart>;

struct HttpReply {
  int status{200};
  std::vector<std::pair<std::string, std::string>> fields;  ///< headers but Content-Length and Connection
  Body body;
};

[[nodiscard]] std::uint64_t length_of(const Body& body);

/// Words for people, as a reply: refusals and errors.
[[nodiscard]] HttpReply plain_reply(int status, const std::string& words);

/// Headers that every reply carries.
void add_common_fields(HttpReply& reply);

}  // namespace stereogrid::server
