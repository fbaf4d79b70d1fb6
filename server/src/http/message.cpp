// SPDX-License-Identifier: Apache-2.0
#include "http/message.hpp"

#include <algorithm>
#include <charconv>

namespace stereogrid::server {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

/// None: '%' without two digits, or a control character, encoded or not.
std::optional<std::string> decoded(std::string_view text) {
  std::string result;
  for (std::size_t i{0}; i < text.size(); ++i) {
    char c{text[i]};
    if (c == '%') {
      if (text.size() - i < 3) return std::nullopt;
      const int high{hex_digit(text[i + 1])};
      const int low{hex_digit(text[i + 2])};
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(16 * high + low);
      i += 2;
    }
    if (is_control(c)) return std::nullopt;
    result.push_back(c);
  }
  return result;
}

/// Calls `take` for each part between the separators, until it says no.
template <class Take>
bool split(std::string_view text, char separator, Take&& take) {
  for (std::size_t start{0}; start <= text.size();) {
    const std::size_t end{std::min(text.find(separator, start), text.size())};
    if (!take(text.substr(start, end - start), end == text.size())) return false;
    start = end + 1;
  }
  return true;
}

bool append_segment(std::string_view segment, bool last, std::string& path) {
  const auto name{decoded(segment)};
  if (!name || *name == "." || *name == ".." || name->find('/') != std::string::npos) return false;
  if (name->empty() && !last) return false;
  path += "/" + *name;
  return true;
}

bool append_pair(std::string_view pair, Target& target) {
  if (pair.empty()) return true;
  const std::size_t equals{std::min(pair.find('='), pair.size())};
  const auto name{decoded(pair.substr(0, equals))};
  const auto value{decoded(pair.substr(std::min(equals + 1, pair.size())))};
  if (!name || !value) return false;
  target.query.emplace_back(*name, *value);
  return true;
}

}  // namespace

const std::string* Target::find(std::string_view name) const {
  const auto found{std::ranges::find(query, name, [](const auto& pair) { return std::string_view{pair.first}; })};
  return found == query.end() ? nullptr : &found->second;
}

std::optional<Target> parse_target(std::string_view text) {
  if (!text.starts_with('/') || text.find('#') != std::string_view::npos) return std::nullopt;
  const std::size_t mark{std::min(text.find('?'), text.size())};
  Target target;
  const bool path_fine{split(text.substr(1, mark - 1), '/', [&](std::string_view segment, bool last) {
    return append_segment(segment, last, target.path);
  })};
  const bool query_fine{mark == text.size() || split(text.substr(mark + 1), '&', [&](std::string_view pair, bool) {
                          return append_pair(pair, target);
                        })};
  if (!path_fine || !query_fine) return std::nullopt;
  return target;
}

namespace {

/// None: empty, not of digits, or too large.
std::optional<std::uint64_t> number(std::string_view digits) {
  std::uint64_t value{0};
  const auto [end, error]{std::from_chars(digits.data(), digits.data() + digits.size(), value)};
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<ByteRange> parse_range(std::string_view header, std::uint64_t size) {
  constexpr std::string_view unit{"bytes="};
  if (!header.starts_with(unit)) return std::nullopt;
  header.remove_prefix(unit.size());
  const std::size_t dash{header.find('-')};
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view first{header.substr(0, dash)};
  const std::string_view last{header.substr(dash + 1)};
  if (first.empty()) {
    const auto count{number(last)};
    if (!count) return std::nullopt;
    return ByteRange{size - std::min(*count, size), size};
  }
  const auto begin{number(first)};
  const auto end{last.empty() ? std::optional{size} : number(last)};
  if (!begin || !end || (!last.empty() && *end < *begin)) return std::nullopt;
  if (*begin >= size) return ByteRange{size, size};
  return ByteRange{*begin, last.empty() ? size : std::min(*end, size - 1) + 1};
}

bool matches_etag(std::string_view header, std::string_view etag) {
  for (std::size_t start{0}; start < header.size();) {
    const std::size_t end{std::min(header.find(',', start), header.size())};
    std::string_view one{header.substr(start, end - start)};
    one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
    if (one.starts_with("W/")) one.remove_prefix(2);
    one = one.substr(0, one.find_last_not_of(' ') + 1);
    if (one == etag || one == "*") return true;
    start = end + 1;
  }
  return false;
}

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
