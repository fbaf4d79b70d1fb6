// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <type_traits>

#include "cli/config_options.hpp"
#include "cli/console.hpp"
#include "cli/program.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/config_file.hpp"

namespace stereogrid::app {
namespace {

struct ListOptions {
  ConfigOptions config;
  bool json{false};
  bool yaml{false};
  bool markdown{false};
};

/// "1 … 500", "true or false" or the names of the choices.
template <class T>
std::string range_of(const Parameter& parameter, const T&) {
  if constexpr (std::is_same_v<T, bool>) {
    return "true, false";
  } else if constexpr (std::is_enum_v<T>) {
    return fmt::format("{}", fmt::join(names_of(T{}), ", "));
  } else {
    return fmt::format("{} … {}", parameter.minimum, parameter.maximum);
  }
}

void print_yaml_like(const Config& config) {
  std::string group_before;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
    if (group != group_before) print("{}{}:\n", group_before.empty() ? "" : "\n", group);
    group_before = group;
    const std::string key{fmt::format("{}.{}", group, parameter.name)};
    const std::string unit{parameter.unit.empty() ? "" : fmt::format(" {}", parameter.unit)};
    print("  {} = {}{}   [{}]\n      {}\n", key, get(config, key), unit, range_of(parameter, value),
          parameter.sentence);
    if (const std::string condition{why_unread(config, key, {})}; !condition.empty()) {
      print("      Not read here: needs {}.\n", condition);
    }
  });
}

void print_markdown() {
  const Config standard{preset("default")};
  const Config paper{preset("paper")};
  print(
      "<!-- SPDX-License-Identifier: Apache-2.0 -->\n"
      "# Parameters\n\n"
      "Made by `stereogrid config --markdown`; do not edit. Set them with `--set group.name=value`, in a file for\n"
      "`--config`, or in C++ as fields of `stereogrid::Config`. Where the preset `paper` differs, its value follows "
      "in\n"
      "brackets.\n");
  std::string group_before;
  visit_parameters(standard, [&](std::string_view group, const Parameter& parameter, const auto& value) {
    if (group != group_before) {
      print("\n## {}\n\n| parameter | default | unit | range | |\n|---|---|---|---|---|\n", group);
    }
    group_before = group;
    const std::string key{fmt::format("{}.{}", group, parameter.name)};
    std::string shown{get(standard, key)};
    if (get(paper, key) != shown) shown += fmt::format(" ({})", get(paper, key));
    print("| `{}` | {} | {} | {} | {} |\n", parameter.name, shown, parameter.unit, range_of(parameter, value),
          parameter.sentence);
  });
}

}  // namespace

void add_config_command(Command tool) {
  auto options{std::make_shared<ListOptions>()};
  const Command command{tool.add_command("config", "List every parameter: value, unit, range, description.")};
  add_config_options(command, options->config);
  command.group(Group::output);
  const Option yaml{
      command.add_flag("--yaml", options->yaml, "Print a file for --config: 'config --yaml > mine.yaml'.")};
  const Option json{command.add_flag("--json", options->json, "Print JSON, values only.")};
  json.excludes(yaml);
  command.add_flag("--markdown", options->markdown, "Print the page docs/config.md.").excludes(json).excludes(yaml);
  command.callback([options] {
    if (options->markdown) return print_markdown();
    const Config config{config_from(options->config)};
    if (const auto found{problems(config)}; !found.empty())
      throw ConfigError{fmt::format("{}", fmt::join(found, "\n"))};
    if (options->json) {
      print("{}\n", io::to_json(config, 2));
    } else if (options->yaml) {
      print("{}", io::to_yaml(config));
    } else {
      print_yaml_like(config);
    }
  });
}

}  // namespace stereogrid::app
