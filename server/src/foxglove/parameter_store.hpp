// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/server/parameter.hpp"

namespace stereogrid::server {

/// The parameters' present values.
class ParameterStore {
 public:
  /// Throws ConfigError: a name that is empty or there twice, a number that is not finite.
  explicit ParameterStore(Parameters parameters);

  [[nodiscard]] std::size_t size() const { return parameters_.size(); }
  /// None: there is no such parameter.
  [[nodiscard]] const Parameter* find(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> names() const;

  /// A client's value, in a type that JSON has. Returns the reason to reject it; none: the parameter has this value
  /// now.
  [[nodiscard]] std::optional<std::string> set(const Parameter& wish);
  /// The owner's word. Throws ConfigError; see check().
  void put(const Parameter& parameter);
  /// Throws ConfigError: no such parameter, another type, a number that is not finite. Reads what never changes.
  void check(const Parameter& parameter) const;

 private:
  std::map<std::string, Parameter> parameters_;
  std::map<std::string, std::size_t> types_;  ///< which of ParameterValue's; never changes, so that any thread may look
  std::function<std::optional<std::string>(const Parameter&)> set_;
};

}  // namespace stereogrid::server
