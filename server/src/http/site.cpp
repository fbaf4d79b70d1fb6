// SPDX-License-Identifier: Apache-2.0
#include "http/site.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <exception>
#include <set>
#include <utility>

#include "foxglove/protocol.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

constexpr int folder_flags{O_RDONLY | O_DIRECTORY | O_CLOEXEC};
constexpr int file_flags{O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC};  // a FIFO must not make it wait

std::string etag_of(const struct stat& file) {
  char text[80];
  std::snprintf(text, sizeof text, "\"%jx-%jx-%jx%09lx\"", static_cast<std::uintmax_t>(file.st_ino),
                static_cast<std::uintmax_t>(file.st_size), static_cast<std::uintmax_t>(file.st_mtim.tv_sec),
                static_cast<unsigned long>(file.st_mtim.tv_nsec));
  return text;
}

}  // namespace

Descriptor open_below(const std::filesystem::path& folder, std::string_view path) {
  Descriptor at{::open(folder.c_str(), folder_flags)};
  while (at) {
    const std::size_t slash{path.find('/')};
    const std::string name{path.substr(0, slash)};
    if (name.empty() || name == "." || name == ".." || name.find('\0') != std::string::npos) break;
    if (slash == std::string_view::npos) return Descriptor{::openat(at.get(), name.c_str(), file_flags)};
    at = Descriptor{::openat(at.get(), name.c_str(), folder_flags | O_NOFOLLOW)};
    path.remove_prefix(slash + 1);
  }
  return Descriptor{-1};
}

std::optional<HttpReply> file_reply(const std::filesystem::path& folder, std::string_view path,
                                    const HttpRequest& request) {
  auto file{std::make_shared<const Descriptor>(open_below(folder, path))};
  struct stat about {};
  if (!*file || ::fstat(file->get(), &about) != 0 || !S_ISREG(about.st_mode)) return std::nullopt;
  const std::string etag{etag_of(about)};
  const auto size{static_cast<std::uint64_t>(about.st_size)};
  HttpReply reply{200, {{"ETag", etag}, {"Accept-Ranges", "bytes"}, {"Cache-Control", "no-cache"}}, {}};
  if (matches_etag(request.if_none_match, etag)) {
    reply.status = 304;
    return reply;
  }
  reply.fields.emplace_back("Content-Type", content_type_of(path));
  ByteRange part{0, size};
  if (request.if_range.empty() || request.if_range == etag) {
    if (const auto range{parse_range(request.range, size)}) {
      part = *range;
      const bool nothing{part.begin == part.end};
      reply.status = nothing ? 416 : 206;
      const std::string asked{nothing ? "*" : std::to_string(part.begin) + "-" + std::to_string(part.end - 1)};
      reply.fields.emplace_back("Content-Range", "bytes " + asked + "/" + std::to_string(size));
    }
  }
  reply.body = FilePart{std::move(file), part.begin, part.end};
  return reply;
}

std::string content_type_of(std::string_view name) {
  static const std::map<std::string_view, const char*> types{{"css", "text/css; charset=utf-8"},
                                                             {"csv", "text/csv; charset=utf-8"},
                                                             {"html", "text/html; charset=utf-8"},
                                                             {"jpg", "image/jpeg"},
                                                             {"js", "text/javascript; charset=utf-8"},
                                                             {"json", "application/json"},
                                                             {"jsonl", "application/x-ndjson"},
                                                             {"mp4", "video/mp4"},
                                                             {"png", "image/png"},
                                                             {"svg", "image/svg+xml"},
                                                             {"txt", "text/plain; charset=utf-8"},
                                                             {"yaml", "application/yaml"}};
  const std::size_t dot{name.rfind('.')};
  const auto found{types.find(dot == std::string_view::npos ? std::string_view{} : name.substr(dot + 1))};
  return found == types.end() ? "application/octet-stream" : found->second;
}

namespace {

/// FNV-1a: distinguishes versions of a page, no more.
std::string etag_of(const std::string& bytes) {
  std::uint64_t hash{0xcbf29ce484222325};
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  char text[40];
  std::snprintf(text, sizeof text, "\"%016jx\"", static_cast<std::uintmax_t>(hash));
  return text;
}

void check_path(const std::string& path, std::set<std::string>& known) {
  const auto target{parse_target(path)};
  if (!target || target->path != path) {
    throw ConfigError{"'" + path + "' cannot be served: a path begins with '/' and has no '..', '?', '#' or '%'."};
  }
  if (!known.insert(path).second) throw ConfigError{"'" + path + "' is to be served twice: paths have to differ."};
}

HttpReply answered(const Endpoint& endpoint) {
  Answer answer;
  try {
    answer = endpoint.answer();
  } catch (const std::exception& error) {
    return plain_reply(500, endpoint.path + " cannot be answered: " + error.what());
  }
  HttpReply reply{
      answer.status, {{"Content-Type", answer.content_type}, {"Cache-Control", "no-store"}}, std::move(answer.body)};
  add_common_fields(reply);
  return reply;
}

}  // namespace

Site::Site(HttpContent content, AccessRules rules) : rules_{std::move(rules)}, folders_{std::move(content.folders)} {
  std::set<std::string> known;
  for (Asset& asset : content.assets) {
    check_path(asset.path, known);
    const std::string etag{etag_of(asset.bytes)};
    pages_[asset.path] = {asset.content_type, asset.content_security_policy, etag,
                          std::make_shared<const std::string>(std::move(asset.bytes))};
  }
  for (Endpoint& endpoint : content.endpoints) {
    check_path(endpoint.path, known);
    endpoints_[endpoint.path] = std::move(endpoint);
  }
  for (const Folder& folder : folders_) {
    check_path(folder.prefix, known);
    if (folder.prefix.ends_with('/')) throw ConfigError{"'" + folder.prefix + "': leave out the last '/'."};
    if (!std::filesystem::is_directory(folder.folder)) {
      throw InputError{folder.folder.string(), "is not a folder.", "Name the folder that is to be served."};
    }
  }
}

HttpReply Site::answer(const HttpRequest& request) const {
  if (const auto refusal{refuse_host(rules_, request)}) return plain_reply(refusal->status, refusal->words);
  const auto target{parse_target(request.target)};
  if (!target) return plain_reply(400, "The address is malformed.");
  if (const auto refusal{refuse_token(rules_, request, *target)}) return plain_reply(refusal->status, refusal->words);
  if (request.method != "GET" && request.method != "HEAD") {
    HttpReply reply{plain_reply(405, "Only GET and HEAD are served.")};
    reply.fields.emplace_back("Allow", "GET, HEAD");
    return reply;
  }
  if (request.has_body) return plain_reply(413, "A request must not have a body here.");
  std::optional<HttpReply> reply{content(request, target->path)};
  if (!reply) return plain_reply(404, "There is nothing at this address.");
  if (!rules_.token.empty() && target->find("token") != nullptr) {
    reply->fields.emplace_back("Set-Cookie",
                               rules_.cookie + "=" + rules_.token + "; Path=/; HttpOnly; SameSite=Strict");
  }
  return std::move(*reply);
}

std::optional<HttpReply> Site::content(const HttpRequest& request, const std::string& path) const {
  if (const auto page{pages_.find(path)}; page != pages_.end()) return page_reply(page->second, request);
  if (const auto endpoint{endpoints_.find(path)}; endpoint != endpoints_.end()) return answered(endpoint->second);
  for (const Folder& folder : folders_) {
    if (!path.starts_with(folder.prefix + "/")) continue;
    auto reply{file_reply(folder.folder, std::string_view{path}.substr(folder.prefix.size() + 1), request)};
    if (!reply) continue;
    reply->fields.emplace_back("Content-Security-Policy", folder.content_security_policy);
    add_common_fields(*reply);
    return reply;
  }
  return std::nullopt;
}

HttpReply Site::page_reply(const Page& page, const HttpRequest& request) {
  HttpReply reply{200, {{"ETag", page.etag}, {"Cache-Control", "no-cache"}}, page.bytes};
  if (matches_etag(request.if_none_match, page.etag)) {
    reply.status = 304;
    reply.body = std::string{};
  } else {
    reply.fields.emplace_back("Content-Type", page.content_type);
  }
  reply.fields.emplace_back("Content-Security-Policy", page.content_security_policy);
  add_common_fields(reply);
  return reply;
}

std::optional<HttpReply> Site::refuse_websocket(const HttpRequest& request) const {
  auto refusal{refuse_host(rules_, request)};
  if (!refusal) refusal = refuse_origin(rules_, request);
  const auto target{parse_target(request.target)};
  if (!refusal && !target) refusal = Refusal{400, "The address is malformed."};
  if (!refusal) refusal = refuse_token(rules_, request, *target);
  if (!refusal && !chosen_subprotocol(request.subprotocols)) {
    refusal = Refusal{400, "Sec-WebSocket-Protocol has to name foxglove.websocket.v1 or foxglove.sdk.v1."};
  }
  if (refusal) return plain_reply(refusal->status, refusal->words);
  return std::nullopt;
}

namespace {

std::string lower(std::string_view text) {
  std::string result{text};
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// Without the port: a user who forwards the port (ssh -L) may have chosen another one.
std::string host_name(std::string_view host) {
  const std::size_t colon{host.rfind(':')};
  const std::size_t bracket{host.rfind(']')};
  const bool has_port{colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket)};
  return lower(has_port ? host.substr(0, colon) : host);
}

std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  for (std::size_t start{0}; start < cookies.size();) {
    const std::size_t end{std::min(cookies.find(';', start), cookies.size())};
    std::string_view pair{cookies.substr(start, end - start)};
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (pair.starts_with(name) && pair.substr(name.size()).starts_with('=')) return pair.substr(name.size() + 1);
    start = end + 1;
  }
  return {};
}

std::string_view bearer(std::string_view authorization) {
  constexpr std::string_view scheme{"bearer "};
  if (lower(authorization.substr(0, scheme.size())) != scheme) return {};
  authorization.remove_prefix(scheme.size());
  authorization.remove_prefix(std::min(authorization.find_first_not_of(' '), authorization.size()));
  return authorization;
}

}  // namespace

std::optional<Refusal> refuse_host(const AccessRules& rules, const HttpRequest& request) {
  if (request.host.empty()) return Refusal{400, "A request needs exactly one header Host."};
  const std::string name{host_name(request.host)};
  if (!rules.loopback || name == "localhost" || name == "127.0.0.1" || name == "[::1]" || name == rules.address) {
    return std::nullopt;
  }
  return Refusal{403, "This server is for this machine only: open it as localhost, 127.0.0.1 or [::1]."};
}

std::optional<Refusal> refuse_origin(const AccessRules& rules, const HttpRequest& request) {
  if (request.origin.empty()) return std::nullopt;  // no browser
  const std::string origin{lower(request.origin)};
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme) && origin.substr(scheme.size()) == lower(request.host)) return std::nullopt;
  }
  const auto is_it{[&](const std::string& allowed) { return lower(allowed) == origin; }};
  if (std::ranges::any_of(rules.allowed_origins, is_it)) return std::nullopt;
  return Refusal{403,
                 "Pages of another site may not connect. Who started the server can allow this page by naming it (" +
                     request.origin.substr(0, 100) + ") among the allowed origins."};
}

std::optional<Refusal> refuse_token(const AccessRules& rules, const HttpRequest& request, const Target& target) {
  if (rules.token.empty()) return std::nullopt;
  const std::string* const asked{target.find("token")};
  const std::string_view candidates[]{asked != nullptr ? std::string_view{*asked} : std::string_view{},
                                      bearer(request.authorization), cookie_value(request.cookie, rules.cookie)};
  for (const std::string_view candidate : candidates) {
    if (equal_in_constant_time(candidate, rules.token)) return std::nullopt;
  }
  return Refusal{401,
                 "A token is needed: open the address that the server printed, with ?token=…, or send a header "
                 "Authorization: Bearer …"};
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference{0};
  for (std::size_t i{0}; i < a.size(); ++i) difference = difference | static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

std::string random_token() {
  std::array<unsigned char, 20> bytes{};
  if (::getentropy(bytes.data(), bytes.size()) != 0) {
    throw DeviceError{"The system gives no random bytes for a token: give one in the options."};
  }
  constexpr char digits[]{"0123456789abcdef"};
  std::string token;
  for (const unsigned char byte : bytes) {
    token.push_back(digits[byte >> 4]);
    token.push_back(digits[byte & 15]);
  }
  return token;
}

void check_token(std::string_view token) {
  constexpr std::size_t shortest{22};  // 128 bits of 6 in a character
  const auto fits{[](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_'; }};
  if (token.size() >= shortest && std::ranges::all_of(token, fits)) return;
  throw ConfigError{"The token has to be of 22 or more letters, digits, '-' and '_'."};
}

}  // namespace stereogrid::server
