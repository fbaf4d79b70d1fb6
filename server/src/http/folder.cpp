// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "http/folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <cstdio>
#include <map>

#include "http/range.hpp"

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

}  // namespace stereogrid::server
