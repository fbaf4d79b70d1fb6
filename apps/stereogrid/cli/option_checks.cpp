// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/option_checks.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
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

std::string complaint_if_empty(const std::string& value) {
  return value.empty() ? "is empty. Give a value, or leave it out." : "";
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

void refuse_empty_values(CLI::App& tool) {
  for (CLI::Option* option : tool.get_options()) {
    if (option->get_items_expected_max() > 0) option->check(complaint_if_empty);
  }
  for (CLI::App* command : tool.get_subcommands({})) refuse_empty_values(*command);
}

}  // namespace stereogrid::app
