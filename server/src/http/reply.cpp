// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "http/reply.hpp"

namespace stereogrid::server {

std::uint64_t length_of(const Body& body) {
  if (const auto* const text{std::get_if<std::string>(&body)}) return text->size();
  if (const auto* const shared{std::get_if<std::shared_ptr<const std::string>>(&body)}) return (*shared)->size();
  const auto& part{std::get<FilePart>(body)};
  return part.end - part.begin;
}

HttpReply plain_reply(int status, const std::string& words) {
  HttpReply reply{status, {{"Content-Type", "text/plain; charset=utf-8"}, {"Cache-Control", "no-store"}}, words + "\n"};
  if (status == 401) reply.fields.emplace_back("WWW-Authenticate", "Bearer");
  add_common_fields(reply);
  return reply;
}

void add_common_fields(HttpReply& reply) {
  reply.fields.emplace_back("X-Content-Type-Options", "nosniff");
  reply.fields.emplace_back("Referrer-Policy", "no-referrer");  // the token may be in the address
  reply.fields.emplace_back("Cross-Origin-Resource-Policy", "same-origin");
}

}  // namespace stereogrid::server
