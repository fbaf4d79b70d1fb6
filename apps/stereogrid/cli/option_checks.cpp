// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/option_checks.hpp"

#include <fmt/format.h>

#include <charconv>
#include <optional>

namespace stereogrid::app {
namespace {

template <class Number>
std::optional<Number> parsed(const std::string& text) {
  Number value{};
  const char* const end{text.data() + text.size()};
  const auto [stop, error]{std::from_chars(text.data(), end, value)};
  if (error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

}  // namespace

OptionCheck whole_number(std::uint64_t minimum, std::uint64_t maximum) {
  return [=](const std::string& text) {
    const auto value{parsed<std::uint64_t>(text)};
    const bool octal{text.size() > 1 && text.front() == '0'};
    if (text.empty() || (value && !octal && *value >= minimum && *value <= maximum)) return std::string{};
    return fmt::format("{} is no whole number from {} to {}.", text, minimum, maximum);
  };
}

OptionCheck number(double minimum, double maximum) {
  return [=](const std::string& text) {
    const auto value{parsed<double>(text)};
    if (text.empty() || (value && *value >= minimum && *value <= maximum)) return std::string{};  // not for nan
    return fmt::format("{} is no number from {:g} to {:g}.", text, minimum, maximum);
  };
}

}  // namespace stereogrid::app
