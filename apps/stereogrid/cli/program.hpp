// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cli/help.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): CLI11's own name
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace stereogrid::app {

class Command;

/// Exit codes of the program.
enum ExitCode : int {
  exit_done = 0,
  exit_usage = 64,         ///< wrong arguments or settings
  exit_input = 65,         ///< input that cannot be used
  exit_bug = 70,           ///< our fault
  exit_try_again = 75,     ///< disk full, device missing, input away
  exit_signal_base = 128,  ///< plus the number of the signal that stopped us
};

// Each adds a sub-command to the tool; running it sets `exit_code` or throws.
void add_run_command(Command tool, int& exit_code);
void add_simulate_command(Command tool, int& exit_code);
void add_evaluate_command(Command tool, int& exit_code);
void add_export_command(Command tool, int& exit_code);
void add_info_command(Command tool, int& exit_code);
void add_live_command(Command tool, int& exit_code);
void add_view_command(Command tool, int& exit_code);
void add_config_command(Command tool);
void add_nav2_params_command(Command tool);
void add_completion_command(Command tool);

/// Returns the fault of an option's value; "": none.
using OptionCheck = std::function<std::string(const std::string& value)>;

/// In decimal digits, both ends included. CLI11's own reading wraps -1 around and takes 010 for eight.
[[nodiscard]] OptionCheck whole_number(std::uint64_t minimum, std::uint64_t maximum);
/// Both ends included; CLI11's own range lets nan through.
[[nodiscard]] OptionCheck number(double minimum, double maximum);

// The command line. Only program.cpp includes CLI11, which would cost each file seconds of compile time.

/// An option of a command. Functions return the option itself.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_{option} {}

  Option required() const;
  /// Its value may be left out, and then is `otherwise`.
  Option optional_value(const std::string& otherwise) const;
  /// Number of its values.
  Option expected(int minimum, int maximum) const;
  Option expected(int values) const { return expected(values, values); }
  /// May be repeated.
  Option take_all() const;
  /// `range`: as --help shows it; "": not at all.
  Option check(const OptionCheck& check, const std::string& range = "") const;
  /// --help and completion show the values.
  Option one_of(const std::vector<std::string>& values) const;
  Option within(int minimum, int maximum) const;
  /// --help has its default.
  Option show_default() const;
  Option needs(Option other) const;
  Option excludes(Option other) const;

 private:
  CLI::Option* option_;
};

/// A program, or one of its commands. Copies are of the same one.
class Command {
 public:
  Command(CLI::App& app) : app_{&app} {}  // NOLINT(google-explicit-constructor): for programs that use CLI11

  void description(const std::string& text) const;
  /// Last part of --help.
  void footer(const std::string& text) const;
  /// Group of the options that are added from now on.
  void group(Group group) const;
  /// Called when the command line is parsed.
  void callback(const std::function<void()>& run) const;
  [[nodiscard]] Command add_command(const std::string& name, const std::string& description) const;
  /// One command has to be given.
  void require_command() const;

  /// `name`: "--out,-o DIR", or "INPUT" for a positional one. After the space: the value in --help and for completion
  /// (OptionText::value); with a comma, one argument may have several values. `Value`: those that program.cpp
  /// instantiates.
  template <class Value>
  Option add_option(const std::string& name, Value& value, const std::string& description) const;
  Option add_option_function(const std::string& name, const std::function<void(const std::string&)>& set,
                             const std::string& description) const;
  Option add_flag(const std::string& name, bool& value, const std::string& description) const;
  [[nodiscard]] Option option(const std::string& name) const;

 private:
  CLI::App* app_;
};

/// Adds options and commands to a program; running it sets `exit_code` or throws.
using Describe = void (*)(CLI::App& program, int& exit_code);

/// main() of a program called `name`: sets up streams, log and memory, parses the command line, and turns exceptions
/// into messages and exit codes.
[[nodiscard]] int run_program(int argc, char** argv, const char* name, Describe describe);

}  // namespace stereogrid::app
