// SPDX-License-Identifier: Apache-2.0
#include "cli/help.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <sstream>

#include "stereogrid/printable.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t names_column{2};
constexpr std::size_t text_column{25};

/// Number of characters of UTF-8.
std::size_t characters_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0U) != 0x80U; }));
}

/// Appends the words of `text` to the last line of `page`, which has `used` characters; further lines begin at
/// `indent`.
void append_wrapped(std::string& page, std::string_view text, std::size_t used, std::size_t indent,
                    std::size_t columns) {
  std::istringstream words{std::string{text}};
  bool is_first{true};
  for (std::string word; words >> word; is_first = false) {
    const std::size_t length{characters_of(word)};
    if (!is_first && used + 1 + length > columns) {
      page += '\n' + std::string(indent, ' ');
      used = indent;
    } else if (!is_first) {
      page += ' ';
      ++used;
    }
    page += word;
    used += length;
  }
  page += '\n';
}

void append_row(std::string& page, const std::string& names, const std::string& text, std::size_t columns) {
  page += std::string(names_column, ' ') + names;
  std::size_t used{names_column + characters_of(names)};
  if (used + 2 > text_column) {
    page += '\n';
    used = 0;
  }
  page += std::string(text_column - used, ' ');
  append_wrapped(page, text, text_column, text_column, columns);
}

void append_paragraphs(std::string& page, const std::string& text, std::size_t columns) {
  std::istringstream lines{text};
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(' ')) {
      page += line + '\n';
    } else {
      append_wrapped(page, line, 0, 0, columns);
    }
  }
}

std::string names_of(const OptionText& option) {
  const std::string value{option.value.empty() ? "" : ' ' + option.value};
  const bool has_literals{option.value.find('|') != std::string::npos};
  if (option.is_positional) return has_literals ? option.value : option.name + value;
  return (option.short_name.empty() ? "" : option.short_name + ", ") + option.name + value;
}

std::string text_of(const OptionText& option) {
  std::string text{option.description};
  if (!option.default_value.empty()) text += fmt::format(" [{}]", option.default_value);
  return text;
}

std::string usage_of(const CommandText& command) {
  std::string usage{"Usage: " + command.name};
  if (!command.commands.empty()) usage += " COMMAND";
  for (const OptionText& option : command.options) {
    if (option.is_positional) usage += option.is_required ? ' ' + names_of(option) : fmt::format(" [{}]", option.name);
  }
  for (const OptionText& option : command.options) {
    if (!option.is_positional && option.is_required) usage += fmt::format(" {} {}", option.name, option.value);
  }
  return usage + " [OPTIONS]";
}

/// The nearest of `names`; none: all are far from `word`.
std::optional<std::string> nearest(const std::vector<std::string>& names, const std::string& word) {
  const auto distance = [&](const std::string& name) -> std::size_t {
    return word.size() > 3 && name.starts_with(word) ? 0 : edit_distance(name, word);
  };
  const auto found{std::ranges::min_element(names, {}, distance)};
  const bool is_near{found != names.end() && distance(*found) <= std::max<std::size_t>(2, word.size() / 3)};
  return is_near ? std::optional{*found} : std::nullopt;
}

std::string question_of(const std::optional<std::string>& name) {
  return name ? fmt::format(" Did you mean '{}'?", *name) : "";
}

}  // namespace

std::string help_of(const CommandText& command, std::size_t columns) {
  std::string page;
  append_wrapped(page, command.description, 0, 0, columns);
  append_wrapped(page, usage_of(command), 0, 4, columns);
  if (std::ranges::any_of(command.options, &OptionText::is_positional)) page += '\n';
  for (const OptionText& option : command.options) {
    if (option.is_positional) append_row(page, names_of(option), text_of(option), columns);
  }
  if (!command.commands.empty()) page += "\nCommands:\n";
  for (const CommandText& one : command.commands) {
    append_row(page, one.name.substr(one.name.rfind(' ') + 1), one.description, columns);
  }
  constexpr auto titles{names_of(Group{})};
  for (std::size_t group{0}; group < titles.size(); ++group) {
    bool is_first{true};
    for (const OptionText& option : command.options) {
      if (option.is_positional || option.group != static_cast<Group>(group)) continue;
      if (is_first) page += fmt::format("\n{}:\n", titles[group]);
      is_first = false;
      append_row(page, names_of(option), text_of(option), columns);
    }
  }
  if (!command.footer.empty()) page += '\n';
  append_paragraphs(page, command.footer, columns);
  return page;
}

std::string unknown_word(const CommandText& command, const std::string& word) {
  const std::string name{printable(word.substr(0, word.find('=')))};
  std::vector<std::string> names;
  const bool is_option{name.starts_with('-')};
  if (is_option) {
    for (const OptionText& option : command.options) {
      if (!option.is_positional) names.push_back(option.name);
    }
    return fmt::format("{}: unknown option.{} '{} --help' lists all.", name, question_of(nearest(names, name)),
                       command.name);
  }
  for (const CommandText& one : command.commands) names.push_back(one.name.substr(one.name.rfind(' ') + 1));
  if (!names.empty()) {
    return fmt::format("{}: unknown command.{} Commands: {}.", name, question_of(nearest(names, name)),
                       fmt::join(names, ", "));
  }
  return fmt::format("{}: unexpected argument. {}", printable(word), usage_of(command));
}

}  // namespace stereogrid::app
