// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace stereogrid::server {

/// Default policy for what a page may load and run: files of this server, no script within the page.
inline constexpr const char* default_content_security_policy{
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self'; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"};

/// Bytes under a path, kept in memory.
struct Asset {
  std::string path;          ///< from "/", as in a URL but not encoded; "/" itself is the front page
  std::string content_type;  ///< such as text/html; charset=utf-8
  std::string bytes;
  std::string content_security_policy{default_content_security_policy};
};

/// Regular files of a folder and of those within it. Files behind a symbolic link are not served.
struct Folder {
  std::string prefix;            ///< such as /results: file a/b.png is /results/a/b.png
  std::filesystem::path folder;  ///< has to exist when the server is made; looked up anew for every request
  std::string content_security_policy{default_content_security_policy};
};

struct Answer {
  int status{200};
  std::string content_type{"text/plain; charset=utf-8"};
  std::string body;
};

/// Text that is made for each request, such as /metrics and /healthz. `answer` is called on the server's thread, which
/// serves no client meanwhile. An exception becomes status 500 with its text.
struct Endpoint {
  std::string path;
  std::function<Answer()> answer;
};

/// Content served over HTTP, to GET and HEAD. An asset goes before an endpoint, that before a folder.
struct HttpContent {
  std::vector<Asset> assets;
  std::vector<Endpoint> endpoints;
  std::vector<Folder> folders;
};

}  // namespace stereogrid::server
