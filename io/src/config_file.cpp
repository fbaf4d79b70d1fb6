// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/config_file.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>
#include <type_traits>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::io {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const YAML::Node& node, const std::string& what) {
  throw ConfigError{fmt::format("{}, line {}: {}", path.string(), node.Mark().line + 1, what)};
}

void set_all(const std::filesystem::path& path, const YAML::Node& map, const std::string& prefix, Config& config) {
  for (const auto& item : map) {
    if (!item.first.IsScalar()) fail(path, item.first, "a key is a word, such as 'grid'.");
    const std::string key{prefix + item.first.Scalar()};
    if (item.second.IsMap()) {
      set_all(path, item.second, key + ".", config);
      continue;
    }
    if (item.second.IsNull()) continue;  // a group whose keys are all commented out
    if (!item.second.IsScalar()) fail(path, item.second, key + " is one value, not a list.");
    try {
      set(config, key, item.second.Scalar());
    } catch (const ConfigError& error) {
      fail(path, item.first, error.what());
    }
  }
}

template <class T>
nlohmann::ordered_json json_of(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return std::string{names_of(T{})[static_cast<std::size_t>(value)]};
  } else {
    return value;
  }
}

template <class T>
std::string range_of(const Parameter& parameter, const T&) {
  if constexpr (std::is_enum_v<T>) {
    return fmt::format("[{}]", fmt::join(names_of(T{}), ", "));
  } else if constexpr (std::is_same_v<T, bool>) {
    return "[true, false]";
  } else {
    return fmt::format("[{} to {}{}{}]", parameter.minimum, parameter.maximum, parameter.unit.empty() ? "" : " ",
                       parameter.unit);
  }
}

}  // namespace

void load_config(const std::filesystem::path& path, Config& config) {
  const std::string text{read_file(path)};
  try {
    const YAML::Node root{YAML::Load(text)};
    if (root.IsNull()) return;
    if (!root.IsMap()) fail(path, root, "holds no settings: there is no 'key: value'.");
    set_all(path, root, "", config);
  } catch (const YAML::Exception& error) {
    throw ConfigError{fmt::format("{}, line {}: is no YAML ({}).", path.string(), error.mark.line + 1, error.msg)};
  }
}

std::string to_json(const Config& config, int indent) {
  nlohmann::ordered_json json;
  visit_parameters(config, [&json](std::string_view group, const Parameter& parameter, const auto& value) {
    json[std::string{group}][std::string{parameter.name}] = json_of(value);
  });
  return json.dump(indent);
}

std::string to_yaml(const Config& config) {
  std::string yaml;
  std::string_view open_group;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
    if (group != open_group) yaml += fmt::format("{}{}:\n", yaml.empty() ? "" : "\n", group);
    open_group = group;
    yaml += fmt::format("  # {} {}\n  {}: {}\n", parameter.sentence, range_of(parameter, value), parameter.name,
                        get(config, fmt::format("{}.{}", group, parameter.name)));
  });
  return yaml;
}

}  // namespace stereogrid::io
