// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/array_list.hpp"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string_view>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number{0};
  const auto [end, error]{std::from_chars(text.data(), text.data() + text.size(), number)};
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<NumberRange> range_in(std::string_view text) {
  const std::size_t dash{text.find('-')};
  const auto first{number_in(text.substr(0, dash))};
  const auto last{dash == std::string_view::npos ? first : number_in(text.substr(dash + 1))};
  if (!first || !last || *last < *first) return std::nullopt;
  return NumberRange{*first, *last};
}

}  // namespace

void ArrayList::add(std::uint64_t number) {
  if (!ranges_.empty() && ranges_.back().last + 1 == number) {
    ranges_.back().last = number;
  } else {
    ranges_.push_back({number, number});
  }
}

std::string ArrayList::text() const {
  std::string list;
  for (const NumberRange& range : ranges_) {
    if (!list.empty()) list += ',';
    list += range.first == range.last ? fmt::format("{}", range.first) : fmt::format("{}-{}", range.first, range.last);
  }
  return list;
}

std::vector<NumberRange> parse_array_list(const std::string& text, std::uint64_t end) {
  std::vector<NumberRange> ranges;
  for (std::size_t at{0}; at <= text.size();) {
    const std::size_t comma{std::min(text.find(',', at), text.size())};
    const auto range{range_in(std::string_view{text}.substr(at, comma - at))};
    if (!range) {
      throw ConfigError{fmt::format("'{}' is no list of shards. Give one such as 3-7,12.", io::printable(text))};
    }
    if (range->last >= end) {
      throw ConfigError{fmt::format("shard {}: the plan has {}, numbered from 0.", range->last, end)};
    }
    ranges.push_back(*range);
    at = comma + 1;
  }
  return ranges;
}

}  // namespace stereogrid::app::batch
