// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "http/descriptor.hpp"

namespace stereogrid::server {

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
