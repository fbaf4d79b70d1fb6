// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/option_checks.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): CLI11's own name
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace stereogrid::app {

// The command line. Only program.cpp includes CLI11, which would cost each file seconds of compile time.

/// An option of a command. Functions return the option itself.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_{option} {}

  /// Name of its value in --help.
  Option type_name(const std::string& name) const;
  Option required() const;
  /// Number of its values.
  Option expected(int minimum, int maximum) const;
  Option expected(int values) const { return expected(values, values); }
  /// May be repeated.
  Option take_all() const;
  /// Between values in one argument.
  Option delimiter(char letter) const;
  /// `range`: as --help shows it.
  Option check(const OptionCheck& check, const std::string& range = "") const;
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
  /// Called when the command line is parsed.
  void callback(const std::function<void()>& run) const;
  [[nodiscard]] Command add_command(const std::string& name, const std::string& description) const;
  /// One command has to be given.
  void require_command() const;

  /// `name`: "--out,-o", or "INPUT" for a positional one. `Value`: those that program.cpp instantiates.
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
