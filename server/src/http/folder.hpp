// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "http/reply.hpp"
#include "http/request.hpp"

namespace stereogrid::server {

/// A regular file below `folder`, open for reading, or none. `path`: relative, decoded (see Target). No path leads out:
/// each folder on the way is opened by itself, and symbolic links are not followed.
[[nodiscard]] Descriptor open_below(const std::filesystem::path& folder, std::string_view path);

/// The file as a reply: whole, a part where the request has a range, 304 where the client has it. None: there is no
/// such file.
[[nodiscard]] std::optional<HttpReply> file_reply(const std::filesystem::path& folder, std::string_view path,
                                                  const HttpRequest& request);

/// By the ending of the name.
[[nodiscard]] std::string content_type_of(std::string_view name);

}  // namespace stereogrid::server
