// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/config_file.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>
#include <set>
#include <type_traits>

#include "input/calibration/yaml_group.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

constexpr std::size_t longest_error{300};

/// Sets what a YAML document names. Aliases may make a small document endless, so that depth and keys are bounded.
class Settings {
 public:
  Settings(const std::filesystem::path& path, Config& config) : path_{path}, config_{config} {}

  void take(const YAML::Node& map, const std::string& prefix, int depth) {
    if (depth > most_groups) fail(map, "groups stand in groups in groups; there are only 'group: {name: value}'.");
    for (const auto& item : map) {
      if (names_.size() == most_keys) fail(map, "there are more keys than parameters by far.");
      if (!item.first.IsScalar()) fail(item.first, "a key is a word, such as 'grid'.");
      const std::string name{prefix + item.first.Scalar()};
      if (!names_.insert(name).second) fail(item.first, "has '" + name + "' again.");
      take_value(item.first, item.second, name, depth);
    }
  }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
    throw ConfigError{
        fmt::format("{}, line {}: {}", printable_path(path_), node.Mark().line + 1, printable(what, longest_error))};
  }

 private:
  static constexpr int most_groups{4};
  static constexpr std::size_t most_values{1000};
  static constexpr std::size_t most_keys{10'000};

  [[nodiscard]] std::string joined(const YAML::Node& list, const std::string& name) const {
    if (list.size() > most_values) fail(list, name + " has more values than a list may have.");
    std::string text;
    for (const YAML::Node& value : list) {
      if (!value.IsScalar()) fail(value, name + " is not a list of numbers.");
      text += (text.empty() ? "" : ",") + value.Scalar();
    }
    return text.empty() ? "none" : text;
  }

  [[nodiscard]] bool is_group(const std::string& name) const {
    bool is_one{false};
    visit_parameters(config_, [&](std::string_view group, const Parameter&, const auto&) { is_one |= group == name; });
    return is_one;
  }

  void take_value(const YAML::Node& key, const YAML::Node& value, const std::string& name, int depth) {
    if (value.IsMap()) return take(value, name + ".", depth + 1);
    if (value.IsNull() && is_group(name)) return;  // its keys are all commented out
    try {
      set(config_, name, value.IsNull() ? "" : value.IsSequence() ? joined(value, name) : value.Scalar());
    } catch (const ConfigError& error) {
      fail(key, error.what());
    }
  }

  std::filesystem::path path_;
  Config& config_;
  std::set<std::string> names_;
};

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
  const std::string text{read_text(path, largest_bytes::settings)};
  try {
    const YAML::Node root{YAML::Load(text)};
    if (root.IsNull()) return;
    Settings settings{path, config};
    if (!root.IsMap()) settings.fail(root, "holds no settings: there is no 'key: value'.");
    settings.take(root, "", 1);
  } catch (const YAML::Exception& error) {
    throw ConfigError{fmt::format("{}, line {}: {}", printable_path(path), error.mark.line + 1, error_text_of(error))};
  }
}

std::string to_json(const Config& config, int indent) {
  nlohmann::ordered_json json;
  visit_parameters(config, [&json](std::string_view group, const Parameter& parameter, const auto& value) {
    json[std::string{group}][std::string{parameter.name}] = json_of(value);
  });
  return json_text(json, indent);
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
