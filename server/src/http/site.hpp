// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"
#include "stereogrid/server/http.hpp"

namespace stereogrid::server {

/// Clients that are served.
struct AccessRules {
  bool loopback{true};  ///< listens where only this machine reaches it
  std::string address;  ///< as in a URL: an IPv6 address is in brackets
  std::string token;    ///< empty: none is needed
  std::string cookie;   ///< its name
  std::vector<std::string> allowed_origins;
};

/// Why a request is refused.
struct Refusal {
  int status;
  std::string words;
};

/// A page of another site may have its name point to this machine (DNS rebinding); the header Host then has that name.
[[nodiscard]] std::optional<Refusal> refuse_host(const AccessRules& rules, const HttpRequest& request);
/// Browsers let any page open a WebSocket anywhere, and say in the header Origin which page it was.
[[nodiscard]] std::optional<Refusal> refuse_origin(const AccessRules& rules, const HttpRequest& request);
/// The token is in the query, in a header "Authorization: Bearer …", or in the cookie that a page was given.
[[nodiscard]] std::optional<Refusal> refuse_token(const AccessRules& rules, const HttpRequest& request,
                                                  const Target& target);

/// In a time that does not depend on where they differ.
[[nodiscard]] bool equal_in_constant_time(std::string_view a, std::string_view b);

/// 160 random bits as 40 hexadecimal digits. Throws DeviceError.
[[nodiscard]] std::string random_token();
/// Throws ConfigError: short, or of other characters than letters, digits, '-' and '_'.
void check_token(std::string_view token);

/// Content served over HTTP, and its access rules; without a network.
class Site {
 public:
  /// Throws ConfigError: a path that is no path or there twice; InputError: a folder that is not there.
  Site(HttpContent content, AccessRules rules);

  [[nodiscard]] HttpReply answer(const HttpRequest& request) const;
  /// Why a WebSocket may not be opened; none: it may.
  [[nodiscard]] std::optional<HttpReply> refuse_websocket(const HttpRequest& request) const;

 private:
  struct Page {
    std::string content_type;
    std::string content_security_policy;
    std::string etag;
    std::shared_ptr<const std::string> bytes;
  };

  [[nodiscard]] std::optional<HttpReply> content(const HttpRequest& request, const std::string& path) const;
  [[nodiscard]] static HttpReply page_reply(const Page& page, const HttpRequest& request);

  AccessRules rules_;
  std::map<std::string, Page> pages_;
  std::map<std::string, Endpoint> endpoints_;
  std::vector<Folder> folders_;
};

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
