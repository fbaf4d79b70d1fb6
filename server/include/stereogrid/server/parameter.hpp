// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace stereogrid::server {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<bool>,
                                    std::vector<std::int64_t>, std::vector<double>, std::vector<std::string>>;

struct Parameter {
  std::string name;
  ParameterValue value;  ///< its type stays; numbers are finite
};

/// Parameters that clients can read and set.
struct Parameters {
  std::vector<Parameter> values;  ///< names are unique
  /// Called for a client's new value, of the parameter's type. Returns the reason to reject it; none: it is accepted.
  /// Runs on the server's thread, which serves no client meanwhile: it should be quick, and what it shares with other
  /// threads is the owner's to guard. An exception counts as a refusal with its text. None at all: clients can only
  /// read.
  std::function<std::optional<std::string>(const Parameter&)> set;
};

}  // namespace stereogrid::server
