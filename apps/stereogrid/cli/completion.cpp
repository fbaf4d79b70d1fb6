// SPDX-License-Identifier: Apache-2.0
#include "cli/help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <type_traits>

#include "stereogrid/config.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app {
namespace {

/// Words of a command line before the last one.
struct Before {
  const CommandText* command;
  std::size_t positionals{0};          ///< number of them
  const OptionText* pending{nullptr};  ///< the last word is its value
};

const OptionText* option_named(const CommandText& command, const std::string& word) {
  const auto found{std::ranges::find_if(command.options, [&](const OptionText& option) {
    return !option.is_positional && (option.name == word || (!word.empty() && option.short_name == word));
  })};
  return found == command.options.end() ? nullptr : &*found;
}

Before read(const CommandText& program, const std::vector<std::string>& words) {
  Before before{&program};
  for (std::size_t i{0}; i + 1 < words.size(); ++i) {
    if (before.pending != nullptr && !words[i].starts_with('-')) {
      before.pending = nullptr;
    } else if (words[i].starts_with('-')) {
      const OptionText* const option{option_named(*before.command, words[i])};
      before.pending = option != nullptr && !option->value.empty() ? option : nullptr;
    } else if (before.command == &program) {
      const auto found{std::ranges::find(program.commands, program.name + ' ' + words[i], &CommandText::name)};
      if (found != program.commands.end()) before.command = &*found;
    } else {
      ++before.positionals;
    }
  }
  return before;
}

/// Candidates of one kind of value: "DIR", "KEY=VALUE", "auto".
std::vector<std::string> values_of(const std::string& kind, const std::string& word) {
  if (kind == "DIR" || kind == "RUN_DIR") return {":folders"};
  if (kind.starts_with("FILE") || kind == "RUN") return {":files"};
  std::vector<std::string> values;
  if (kind == "INPUT" || kind == "SCENE") {
    if (kind == "INPUT") values.emplace_back(":files");
    for (const std::string& name : scenes::scene_names()) values.push_back((kind == "INPUT" ? "scene:" : "") + name);
  } else if (kind == "KEY=VALUE") {
    const Config config;
    visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
      const std::string key{fmt::format("{}.{}=", group, parameter.name)};
      using Value = std::decay_t<decltype(value)>;
      if (!word.starts_with(key)) {
        values.push_back(fmt::format("{}\t{}", key, parameter.sentence));
      } else if constexpr (std::is_same_v<Value, bool>) {
        values.insert(values.end(), {key + "true", key + "false"});
      } else if constexpr (std::is_enum_v<Value>) {
        for (const std::string_view name : names_of(Value{})) values.push_back(fmt::format("{}{}", key, name));
      }
    });
  } else if (kind.starts_with("LAYER")) {
    const std::string done{word.substr(0, word.rfind(',') + 1)};
    for (const std::string& layer : io::grid_arrays(false)) values.push_back(done + layer);
  } else if (std::ranges::none_of(kind, [](unsigned char letter) { return std::isupper(letter) != 0; })) {
    values.push_back(kind);
  }
  return values;
}

void append_values(std::vector<std::string>& candidates, const std::string& kinds, const std::string& word,
                   const std::string& prefix) {
  std::istringstream parts{kinds};
  for (std::string kind; std::getline(parts, kind, '|');) {
    std::erase_if(kind, [](char letter) { return letter == '[' || letter == ']'; });
    for (const std::string& value : values_of(kind, word)) {
      const bool is_path{value.starts_with(':')};
      if (is_path || value.starts_with(word)) candidates.push_back(is_path ? value : prefix + value);
    }
  }
}

std::string line_of(const std::string& word, const std::string& description) {
  return word + '\t' + description.substr(0, description.find(". "));
}

}  // namespace

std::vector<std::string> completions(const CommandText& program, const std::vector<std::string>& words) {
  const std::string word{words.empty() ? "" : words.back()};
  const Before before{read(program, words)};
  std::vector<std::string> candidates;
  if (word.starts_with('-')) {
    const std::size_t equals{word.find('=')};
    const OptionText* const option{option_named(*before.command, word.substr(0, equals))};
    if (equals != std::string::npos && option != nullptr) {
      append_values(candidates, option->value, word.substr(equals + 1), word.substr(0, equals + 1));
      return candidates;
    }
    for (const OptionText& one : before.command->options) {
      if (!one.is_positional && one.name.starts_with(word)) candidates.push_back(line_of(one.name, one.description));
    }
    return candidates;
  }
  if (before.pending != nullptr) append_values(candidates, before.pending->value, word, "");
  if (before.pending != nullptr && !before.pending->value.starts_with('[')) return candidates;
  for (const CommandText& command : before.command->commands) {
    const std::string name{command.name.substr(program.name.size() + 1)};
    if (name.starts_with(word)) candidates.push_back(line_of(name, command.description));
  }
  std::vector<std::string> positionals;
  for (const OptionText& option : before.command->options) {
    if (option.is_positional)
      positionals.push_back(option.value.find('|') == std::string::npos ? option.name : option.value);
  }
  if (positionals.empty()) return candidates;
  append_values(candidates, positionals[std::min(before.positionals, positionals.size() - 1)], word, "");
  return candidates;
}

}  // namespace stereogrid::app
