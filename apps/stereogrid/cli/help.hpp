// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace stereogrid::app {

/// Groups of options, in the order of --help: most used ones first.
enum class Group { output, input, scene, parameters, device, long_runs, other_input, files, messages, page, general };
constexpr std::array<std::string_view, 11> names_of(Group) {
  return {"Output",
          "Input",
          "Scene",
          "Grid and camera",
          "Speed and device",
          "Parts of a drive, long runs",
          "Depth, disparities, bags and videos",
          "Contents of the files",
          "Messages and ROS 2",
          "Page in the browser",
          "General"};
}

/// Option or positional argument of a command, as --help, suggestions and completion need it.
struct OptionText {
  std::string name;          ///< "--out"; positional: "INPUT"
  std::string short_name{};  ///< "-o"; "": none
  /// "DIR", "auto|cpu|cuda"; in brackets: may be left out; "": a flag. Words in lower case are literal.
  std::string value{};
  std::string description{};
  std::string default_value{};  ///< "": not shown
  Group group{Group::general};
  bool is_positional{false};
  bool is_required{false};
};

/// A program or one of its commands.
struct CommandText {
  std::string name;  ///< "stereogrid run"
  std::string description{};
  std::string footer{};  ///< a paragraph per line; lines that begin with a space are not wrapped
  std::vector<OptionText> options{};
  std::vector<CommandText> commands{};
};

/// Text of --help in lines of at most `columns` characters, except words that are longer.
[[nodiscard]] std::string help_of(const CommandText& command, std::size_t columns);

/// Message about a word of the command line that `command` has no use for, with the nearest option or command.
[[nodiscard]] std::string unknown_word(const CommandText& command, const std::string& word);

/// First argument with which the scripts of packaging/completion call the program; the words of the command line
/// follow.
constexpr std::string_view completion_request{"__complete"};

/// Candidates for the last of `words`, the part of the command line after the program's name: "WORD\tDESCRIPTION", or
/// ":files" or ":folders" where the shell completes paths.
[[nodiscard]] std::vector<std::string> completions(const CommandText& program, const std::vector<std::string>& words);

}  // namespace stereogrid::app
