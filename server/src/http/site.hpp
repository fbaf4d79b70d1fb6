// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "http/access.hpp"
#include "http/reply.hpp"
#include "stereogrid/server/http.hpp"

namespace stereogrid::server {

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

}  // namespace stereogrid::server
