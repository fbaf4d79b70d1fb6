// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/server/metrics.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

bool is_name(std::string_view name, bool colons) {
  const auto is_letter{
      [&](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (colons && c == ':'); }};
  const auto fits{[&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); }};
  return !name.empty() && is_letter(name[0]) && std::ranges::all_of(name, fits);
}

std::string escaped(std::string_view text, bool quotes) {
  std::string result;
  for (const char c : text) {
    if (c == '\\' || (quotes && c == '"')) result.push_back('\\');
    result += c == '\n' ? std::string{"\\n"} : std::string{c};
  }
  return result;
}

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  char text[32];
  const auto end{std::to_chars(text, text + sizeof text, value).ptr};
  return {text, end};
}

}  // namespace

void Metrics::counter(std::string_view name, std::string_view help) {
  begin(name, help, "counter");
}

void Metrics::gauge(std::string_view name, std::string_view help) {
  begin(name, help, "gauge");
}

void Metrics::begin(std::string_view name, std::string_view help, std::string_view type) {
  if (!is_name(name, true)) throw ConfigError{"'" + std::string{name} + "' cannot be the name of a metric."};
  if (std::ranges::find(names_, name) != names_.end()) {
    throw ConfigError{"Metric '" + std::string{name} + "' is there already: its values have to stand together."};
  }
  names_.emplace_back(name);
  text_ += "# HELP " + names_.back() + " " + escaped(help, false) + "\n# TYPE " + names_.back() + " ";
  text_ += std::string{type} + "\n";
}

void Metrics::sample(double value, const Labels& labels) {
  if (names_.empty()) throw ConfigError{"A value needs a metric: begin one with counter() or gauge()."};
  std::string list;
  for (const auto& [name, label] : labels) {
    if (!is_name(name, false) || name.starts_with("__")) {
      throw ConfigError{"'" + name + "' cannot be the name of a label."};
    }
    list += (list.empty() ? "" : ",") + name + "=\"" + escaped(label, true) + "\"";
  }
  text_ += names_.back() + (list.empty() ? "" : "{" + list + "}") + " " + number(value) + "\n";
}

}  // namespace stereogrid::server
