// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

constexpr std::size_t most_variants{10'000};

std::vector<std::string> settings_of(const std::string& sweep) {
  const std::size_t equals{sweep.find('=')};
  const std::string key{sweep.substr(0, equals)};
  const std::string values{equals == std::string::npos ? "" : sweep.substr(equals + 1)};
  const char separator{values.find('|') == std::string::npos ? ',' : '|'};
  std::vector<std::string> settings;
  std::set<std::string> seen;
  for (std::size_t at{0}; at <= values.size();) {
    const std::size_t end{std::min(values.find(separator, at), values.size())};
    const std::string value{values.substr(at, end - at)};
    if (key.empty() || value.empty() || !seen.insert(value).second) {
      throw ConfigError{
          fmt::format("--sweep {}: give KEY=A,B,C with different values, such as filter.forgetting_s=1,2,4.",
                      io::printable(sweep))};
    }
    settings.push_back(key + '=' + value);
    at = end + 1;
  }
  return settings;
}

}  // namespace

std::vector<std::vector<std::string>> combinations(const std::vector<std::string>& sweeps) {
  std::vector<std::vector<std::string>> all{{}};
  for (const std::string& sweep : sweeps) {
    const std::vector<std::string> settings{settings_of(sweep)};
    if (all.size() * settings.size() > most_variants) {
      throw ConfigError{fmt::format("--sweep: more than {} combinations. Make several plans.", most_variants)};
    }
    std::vector<std::vector<std::string>> longer;
    for (const std::vector<std::string>& before : all) {
      for (const std::string& setting : settings) {
        longer.push_back(before);
        longer.back().push_back(setting);
      }
    }
    all = std::move(longer);
  }
  return all;
}

}  // namespace stereogrid::app::batch
