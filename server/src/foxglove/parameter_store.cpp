// SPDX-License-Identifier: Apache-2.0
#include "foxglove/hub.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

constexpr const char* type_names[]{"a boolean",
                                   "a whole number",
                                   "a number",
                                   "a string",
                                   "an array of booleans",
                                   "an array of whole numbers",
                                   "an array of numbers",
                                   "an array of strings"};
static_assert(std::size(type_names) == std::variant_size_v<ParameterValue>);

bool is_finite(const ParameterValue& value) {
  if (const auto* const number{std::get_if<double>(&value)}) return std::isfinite(*number);
  const auto* const array{std::get_if<std::vector<double>>(&value)};
  return array == nullptr || std::ranges::all_of(*array, [](double number) { return std::isfinite(number); });
}

bool is_empty_array(const ParameterValue& value) {
  const auto* const array{std::get_if<std::vector<bool>>(&value)};  // value that request.cpp makes of []
  return array != nullptr && array->empty();
}

/// JSON does not distinguish 3 from 3.0, and an empty array has no type.
ParameterValue adapted(const ParameterValue& value, const ParameterValue& like) {
  if (const auto* const whole{std::get_if<std::int64_t>(&value)}; whole && std::holds_alternative<double>(like)) {
    return static_cast<double>(*whole);
  }
  const bool numbers{std::holds_alternative<std::vector<double>>(like)};
  if (const auto* const whole{std::get_if<std::vector<std::int64_t>>(&value)}; whole && numbers) {
    return std::vector<double>(whole->begin(), whole->end());
  }
  if (is_empty_array(value)) {
    if (numbers) return std::vector<double>{};
    if (std::holds_alternative<std::vector<std::int64_t>>(like)) return std::vector<std::int64_t>{};
    if (std::holds_alternative<std::vector<std::string>>(like)) return std::vector<std::string>{};
  }
  return value;
}

}  // namespace

ParameterStore::ParameterStore(Parameters parameters) : set_{std::move(parameters.set)} {
  for (Parameter& parameter : parameters.values) {
    const std::string name{parameter.name};
    if (name.empty()) throw ConfigError{"A parameter without a name: give it one."};
    if (!is_finite(parameter.value))
      throw ConfigError{"Parameter '" + name + "' is not finite: JSON has no such number."};
    types_.emplace(name, parameter.value.index());
    if (!parameters_.emplace(name, std::move(parameter)).second) {
      throw ConfigError{"Parameter '" + name + "' is given twice: names have to differ."};
    }
  }
}

const Parameter* ParameterStore::find(const std::string& name) const {
  const auto found{parameters_.find(name)};
  return found == parameters_.end() ? nullptr : &found->second;
}

std::vector<std::string> ParameterStore::names() const {
  std::vector<std::string> names;
  for (const auto& [name, parameter] : parameters_) names.push_back(name);
  return names;
}

std::optional<std::string> ParameterStore::set(const Parameter& requested) {
  const auto found{parameters_.find(requested.name)};
  if (found == parameters_.end()) return "there is no such parameter.";
  if (!set_) return "it can only be read.";
  const Parameter parameter{requested.name, adapted(requested.value, found->second.value)};
  const std::size_t type{found->second.value.index()};
  if (parameter.value.index() != type) return std::string{"it has to be "} + type_names[type] + ".";
  try {
    if (auto refusal{set_(parameter)}) return refusal;
  } catch (const std::exception& error) {
    return error.what();
  }
  found->second = parameter;
  return std::nullopt;
}

void ParameterStore::put(const Parameter& parameter) {
  check(parameter);
  parameters_.at(parameter.name) = parameter;
}

void ParameterStore::check(const Parameter& parameter) const {
  const auto type{types_.find(parameter.name)};
  if (type == types_.end()) throw ConfigError{"Parameter '" + parameter.name + "' was not given to the server."};
  if (parameter.value.index() != type->second) {
    throw ConfigError{"Parameter '" + parameter.name + "' has to be " + type_names[type->second] + "."};
  }
  if (!is_finite(parameter.value)) {
    throw ConfigError{"Parameter '" + parameter.name + "' is not finite: JSON has no such number."};
  }
}

}  // namespace stereogrid::server
