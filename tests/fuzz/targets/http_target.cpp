// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "http/message.hpp"
#include "http/site.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

using namespace stereogrid::server;

const std::string token{"0123456789abcdef012345"};

/// <folder>/inside is served; files beside it must not be.
struct Files {
  Files() {
    folder.write("inside/a.txt", "inside");
    folder.write("inside/sub/b.txt", "inside too");
    folder.write("secret.txt", "SECRET");
    std::filesystem::create_symlink("../secret.txt", folder / "inside/link");
    std::filesystem::create_directory_symlink("..", folder / "inside/up");
  }
  Folder folder;
};

const Files& files() {
  static const Files made;
  return made;
}

void check_target(std::string_view text) {
  const auto target{parse_target(text)};
  if (!target) return;
  require(target->path.starts_with('/'), "a path that begins with something else");
  const auto is_control{[](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }};
  require(std::ranges::none_of(target->path, is_control), "a control character in a path");
  require((target->path + "/").find("/../") == std::string::npos, "a path that leads up");
}

void check_file(std::string_view path) {
  const Descriptor file{open_below(files().folder / "inside", path)};
  if (!file) return;
  std::error_code error;
  const auto real{std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file.get()), error)};
  const auto root{std::filesystem::canonical(files().folder / "inside")};
  require(!error && real.string().starts_with(root.string() + "/"), "a file outside of the folder");
}

HttpRequest request_of(const std::vector<std::string_view>& parts) {
  HttpRequest request;
  const std::array fields{&request.target,        &request.host,          &request.origin,
                          &request.authorization, &request.cookie,        &request.range,
                          &request.if_range,      &request.if_none_match, &request.subprotocols};
  for (std::size_t i{0}; i < fields.size(); ++i) *fields[i] = parts[i];
  request.method = "GET";
  return request;
}

void check_answer(const HttpRequest& request, bool with_token) {
  HttpContent content;
  content.assets = {{"/", "text/html", "front"}};
  content.folders = {{"/files", files().folder / "inside"}};
  const Site site{content, {true, "127.0.0.1", with_token ? token : "", "cookie", {"https://viewer.example"}}};
  const HttpReply reply{site.answer(request)};
  require(std::ranges::count(std::array{200, 206, 304, 400, 401, 403, 404, 416}, reply.status) == 1, "another status");
  const bool has_token{(request.target + request.authorization + request.cookie).find('0') != std::string::npos};
  require(!with_token || has_token || reply.status >= 400, "let in without a token");
  if (const auto* const part{std::get_if<FilePart>(&reply.body)}) {
    require(part->begin <= part->end && part->end <= 10, "a range beyond the file");
  }
  if (!site.refuse_websocket(request)) require(!request.subprotocols.empty(), "a WebSocket without sub-protocol");
}

}  // namespace

/// A request: target, Host, Origin, Authorization, Cookie, ranges, tags, sub-protocols.
FUZZ_TARGET(http_target) {
  const auto parts{parts_of(input, 9)};
  check_target(parts[0]);
  check_file(parts[0]);
  const HttpRequest request{request_of(parts)};
  check_answer(request, false);
  check_answer(request, true);
}

}  // namespace stereogrid::fuzz
