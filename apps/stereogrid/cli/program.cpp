// SPDX-License-Identifier: Apache-2.0
#include "cli/program.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <filesystem>
#include <new>
#include <sstream>

#include "cli/console.hpp"
#include "device_options.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/printable.hpp"

namespace stereogrid::app {
namespace {

// Images come and go with every frame. What malloc hands back to the system each time, the system has to clear each
// time.
void keep_memory() {
#ifdef __GLIBC__
  constexpr int largest_image_bytes{32 << 20};  // more is not allowed
  constexpr int kept_bytes{256 << 20};
  mallopt(M_MMAP_THRESHOLD, largest_image_bytes);
  mallopt(M_TRIM_THRESHOLD, kept_bytes);
#endif
}

int failed(const char* name, int exit_code, const std::string& message) {
  print_error(name, message);
  return exit_code;
}

std::string finding_if_empty(const std::string& value) {
  return value.empty() ? "is empty. Give a value, or leave it out." : "";
}

/// Rejects empty values for all options of the tool and its commands. They come from unset variables of a script, and
/// ignoring the option would not be intended.
void refuse_empty_values(CLI::App& tool) {
  for (CLI::Option* option : tool.get_options()) {
    if (option->get_items_expected_max() > 0) option->check(finding_if_empty);
  }
  for (CLI::App* command : tool.get_subcommands({})) refuse_empty_values(*command);
}

OptionText text_of(const CLI::Option& option) {
  OptionText text;
  text.is_positional = option.get_positional();
  text.name = text.is_positional ? option.get_name(true) : "--" + option.get_lnames().front();
  if (!option.get_snames().empty()) text.short_name = "-" + option.get_snames().front();
  if (option.get_items_expected_max() > 0) text.value = option.get_type_name();
  text.description = option.get_description();
  if (option.get_expected_min() > 0) text.default_value = option.get_default_str();
  constexpr auto titles{names_of(Group{})};
  const auto title{std::ranges::find(titles, option.get_group())};
  text.group = title == titles.end() ? Group::general : static_cast<Group>(title - titles.begin());
  text.is_required = option.get_required();
  return text;
}

/// With the options of the program that every command takes, too.
CommandText text_of(const CLI::App& app) {
  CommandText text{.name = app.get_name(), .description = app.get_description(), .footer = app.get_footer()};
  for (const CLI::Option* option : app.get_options({})) text.options.push_back(text_of(*option));
  for (const CLI::App* command : app.get_subcommands({})) text.commands.push_back(text_of(*command));
  if (app.get_parent() == nullptr) return text;
  text.name = app.get_parent()->get_name() + ' ' + text.name;
  for (const CLI::Option* option : app.get_parent()->get_options({})) {
    if (option != app.get_parent()->get_help_ptr() && !option->check_lname("version")) {
      text.options.push_back(text_of(*option));
    }
  }
  return text;
}

bool is_input(const std::string& word) {
  return word.find_first_of("/.:") != std::string::npos || io::is_there(word);
}

/// Reason why the command line cannot be parsed. Unknown words come first: a misspelt option is not missing, too.
std::string usage_problem(const CLI::App& program, const CLI::ParseError& error) {
  const auto commands{program.get_subcommands()};
  const CLI::App& used{commands.empty() ? program : *commands.front()};
  const std::vector<std::string> unknown{program.remaining(true)};
  const auto option{std::ranges::find_if(unknown, [](const std::string& word) { return word.starts_with('-'); })};
  if (option != unknown.end()) return unknown_word(text_of(used), *option);
  if (!unknown.empty()) return unknown_word(text_of(used), unknown.front());
  std::string problem{error.what()};
  for (const CLI::Option* greedy :
       used.get_options([](const CLI::Option* one) { return one->get_expected_min() == 0; })) {
    if (greedy->get_items_expected_max() == 0 || greedy->empty() ||
        greedy->results().front() == greedy->get_default_str() || !is_input(greedy->results().front()))
      continue;
    problem +=
        fmt::format("; {} took '{}': give INPUT first", greedy->get_name(), printable(greedy->results().front()));
  }
  return fmt::format("{}\n'{} --help' lists all options.", problem, text_of(used).name);
}

/// Words of the command line, last first, as CLI11 takes them. An option with a choice of values that may be left out
/// takes no input for its value: `--pictures INPUT`.
std::vector<std::string> words_of(const CLI::App& program, std::vector<std::string> words) {
  for (const CLI::App* command : program.get_subcommands({})) {
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_expected_min() > 0 || option->get_type_name().find('|') == std::string::npos) continue;
      for (std::size_t i{0}; i + 1 < words.size(); ++i) {
        if (words[i] == option->get_name() && is_input(words[i + 1])) words[i] += '=' + option->get_default_str();
      }
    }
  }
  std::ranges::reverse(words);
  return words;
}

int parse_and_run(int argc, char** argv, const char* name, Describe describe) {
  CLI::App program{"", name};
  program.formatter_fn([](const CLI::App* app, const std::string&, CLI::AppFormatMode) {
    return help_of(text_of(*app), terminal_columns());
  });
  program.get_help_ptr()->description("Print this text.");
  int exit_code{exit_done};
  program.set_version_flag("--version", fmt::format("{} {}", name, version()), "Print the version.");
  program
      .add_flag_callback(
          "-q,--quiet", [] { spdlog::set_level(spdlog::level::warn); }, "Print warnings and errors only.")
      ->trigger_on_parse();
  program
      .add_flag_callback(
          "-v,--verbose", [] { spdlog::set_level(spdlog::level::debug); }, "Print debug messages.")
      ->trigger_on_parse();
  describe(program, exit_code);
  if (argc > 1 && argv[1] == completion_request) {
    for (const std::string& line : completions(text_of(program), {argv + 2, argv + argc})) print("{}\n", line);
    return exit_done;
  }
  refuse_empty_values(program);
  try {
    program.parse(words_of(program, {argv + 1, argv + argc}));
  } catch (const CLI::Success& help_or_version) {
    if (program.get_subcommands().empty() && program.remaining_size() > 0) {
      return failed(name, exit_usage, unknown_word(text_of(program), program.remaining().front()));
    }
    std::ostringstream text;
    const int code{program.exit(help_or_version, text)};
    write_output(text.str());
    return code;
  } catch (const CLI::ParseError& error) {
    return failed(name, exit_usage, usage_problem(program, error));
  }
  return exit_code;
}

int run_guarded(int argc, char** argv, const char* name, Describe describe) {
  try {
    return io::with_path_errors([&] { return parse_and_run(argc, argv, name, describe); });
  } catch (const ConfigError& error) {
    return failed(name, exit_usage, error.what());
  } catch (const InputError& error) {
    return failed(name, exit_input, error.what());
  } catch (const DeviceError& error) {
    return failed(name, exit_try_again, error.what());
  } catch (const std::bad_alloc&) {
    return failed(name, exit_try_again, "out of memory. Smaller images, a smaller grid or fewer velocities need less.");
  } catch (const std::exception& error) {
    const std::string of_thread{thread_failure(error)};
    if (!of_thread.empty()) return failed(name, exit_try_again, of_thread);
    return failed(name, exit_bug,
                  std::string{"internal error: "} + error.what() +
                      "\nThis is a bug in stereogrid. Please report it with the command line and the input.");
  }
}

// "--out,-o DIR" as Command::add_option() has it.
std::string option_names(const std::string& name) {
  return name.substr(0, name.find(' '));
}

Option with_value(const std::string& name, CLI::Option* option) {
  const std::string value{name.substr(std::min(name.find(' '), name.size() - 1) + 1)};
  if (value.find(',') != std::string::npos) option->delimiter(',');
  return Option{option->type_name(value)};
}

}  // namespace

Option Option::required() const {
  return Option{option_->required()};
}

Option Option::optional_value(const std::string& otherwise) const {
  return Option{option_->expected(0, 1)->default_str(otherwise)};
}

Option Option::expected(int minimum, int maximum) const {
  return Option{minimum == maximum ? option_->expected(minimum) : option_->expected(minimum, maximum)};
}

Option Option::take_all() const {
  return Option{option_->take_all()};
}

Option Option::check(const OptionCheck& check, const std::string& range) const {
  if (!range.empty()) option_->description(fmt::format("{} Range: {}.", option_->get_description(), range));
  return Option{option_->check(check)};
}

Option Option::one_of(const std::vector<std::string>& values) const {
  return Option{
      option_->type_name(fmt::format("{}", fmt::join(values, "|")))->check(CLI::IsMember(values).description(""))};
}

Option Option::within(int minimum, int maximum) const {
  return Option{option_->check(CLI::Range(minimum, maximum).description(""))};
}

Option Option::show_default() const {
  return Option{option_->capture_default_str()};
}

Option Option::needs(Option other) const {
  return Option{option_->needs(other.option_)};
}

Option Option::excludes(Option other) const {
  return Option{option_->excludes(other.option_)};
}

void Command::description(const std::string& text) const {
  app_->description(text);
}

void Command::footer(const std::string& text) const {
  app_->footer(text);
}

void Command::group(Group group) const {
  app_->option_defaults()->group(std::string{names_of(Group{}).at(static_cast<std::size_t>(group))});
}

void Command::callback(const std::function<void()>& run) const {
  app_->callback(run);
}

Command Command::add_command(const std::string& name, const std::string& description) const {
  CLI::App* const command{app_->add_subcommand(name, description)};
  command->fallthrough();
  command->get_help_ptr()->description("Print this text.");
  return *command;
}

void Command::require_command() const {
  app_->require_subcommand(0, 1);
  app_->callback([app = app_] {
    if (app->get_subcommands().empty()) throw CLI::RequiredError{"A command"};
  });
}

template <class Value>
Option Command::add_option(const std::string& name, Value& value, const std::string& description) const {
  return with_value(name, app_->add_option(option_names(name), value, description));
}

template Option Command::add_option(const std::string&, int&, const std::string&) const;
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;
template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, std::filesystem::path&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<int>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;

Option Command::add_option_function(const std::string& name, const std::function<void(const std::string&)>& set,
                                    const std::string& description) const {
  return with_value(name, app_->add_option_function<std::string>(option_names(name), set, description));
}

Option Command::add_flag(const std::string& name, bool& value, const std::string& description) const {
  return Option{app_->add_flag(name, value, description)};
}

Option Command::option(const std::string& name) const {
  return Option{app_->get_option(name)};
}

int run_program(int argc, char** argv, const char* name, Describe describe) {
  if (!open_standard_streams()) return exit_try_again;
  set_up_log();
  keep_memory();
  std::signal(SIGXFSZ, SIG_IGN);  // a file above `ulimit -f` then cannot be written, as on a full disk
  const int exit_code{run_guarded(argc, argv, name, describe)};
  const std::string lost{lost_output()};
  if (!lost.empty()) {
    print_error(name, "standard output is not all there (" + lost + "). Send it where there is space.");
  }
  flush_errors();
  const bool is_failure{!lost.empty() && exit_code == exit_done && interrupted() == 0};
  return is_failure ? exit_try_again : exit_code;
}

namespace {

template <class Number>
std::optional<Number> parsed(const std::string& text) {
  Number value{};
  const char* const end{text.data() + text.size()};
  const auto [stop, error]{std::from_chars(text.data(), end, value)};
  if (error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

}  // namespace

OptionCheck whole_number(std::uint64_t minimum, std::uint64_t maximum) {
  return [=](const std::string& text) {
    const auto value{parsed<std::uint64_t>(text)};
    const bool octal{text.size() > 1 && text.front() == '0'};
    if (text.empty() || (value && !octal && *value >= minimum && *value <= maximum)) return std::string{};
    return fmt::format("{} is not a whole number from {} to {}.", text, minimum, maximum);
  };
}

OptionCheck number(double minimum, double maximum) {
  return [=](const std::string& text) {
    const auto value{parsed<double>(text)};
    if (text.empty() || (value && *value >= minimum && *value <= maximum)) return std::string{};  // not for nan
    return fmt::format("{} is not a number from {:g} to {:g}.", text, minimum, maximum);
  };
}

}  // namespace stereogrid::app
