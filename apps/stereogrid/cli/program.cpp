// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/program.hpp"

#include <fmt/format.h>
#include <spdlog/details/os.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <sstream>
#include <string>
#include <string_view>

#include "cli/commands.hpp"
#include "cli/console.hpp"
#include "cli/option_checks.hpp"
#include "device_options.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/printable.hpp"

namespace stereogrid::app {
namespace {

constexpr std::size_t longest_message{16'384};

constexpr const char* wipe_line{"\r\033[K"};  // removes the progress bar

constexpr std::string_view color_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::info:
      return "\033[32m";  // green
    case spdlog::level::warn:
      return "\033[33m\033[1m";  // yellow, bold
    case spdlog::level::err:
    case spdlog::level::critical:
      return "\033[31m\033[1m";  // red, bold
    default:
      return "\033[36m";  // cyan
  }
}

/// To stderr, which nothing waits for (console.hpp). Lines may quote names of files and topics.
class Log final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit Log(bool has_colors) : has_colors_{has_colors} {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text{printable_lines({message.payload.data(), message.payload.size()}, longest_message)};
    spdlog::details::log_msg shown{message};
    shown.payload = text;
    spdlog::memory_buf_t buffer;
    formatter_->format(shown, buffer);
    std::string line{buffer.data(), buffer.size()};
    if (has_colors_ && shown.color_range_end > shown.color_range_start) {
      line.insert(shown.color_range_end, "\033[m");
      line.insert(shown.color_range_start, color_of(message.level));
    }
    write_error(line);
  }
  void flush_() override { flush_errors(); }

  bool has_colors_;
};

void set_up_log() {
  const bool terminal{isatty(STDERR_FILENO) == 1};
  const bool has_colors{terminal && spdlog::details::os::is_color_terminal()};
  auto log{std::make_shared<spdlog::logger>("stereogrid", std::make_shared<Log>(has_colors))};
  log->set_pattern(fmt::format("{}%^%l%$: %v", terminal ? wipe_line : ""));
  spdlog::set_default_logger(std::move(log));
}

int complain(const char* name, int exit_code, const std::string& message) {
  tell_on_stderr("{}{}: {}\n", isatty(STDERR_FILENO) == 1 ? wipe_line : "", name,
                 printable_lines(message, longest_message));
  return exit_code;
}

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

int parse_and_run(int argc, char** argv, const char* name, Describe describe) {
  CLI::App program;
  int exit_code{exit_done};
  program.set_version_flag("--version", fmt::format("{} {}", name, version()));
  program
      .add_flag_callback(
          "-q,--quiet", [] { spdlog::set_level(spdlog::level::warn); }, "Print warnings and errors only.")
      ->trigger_on_parse();
  program
      .add_flag_callback(
          "-v,--verbose", [] { spdlog::set_level(spdlog::level::debug); }, "Print debug messages.")
      ->trigger_on_parse();
  describe(program, exit_code);
  refuse_empty_values(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    std::ostringstream text;
    const int code{program.exit(help_or_version, text)};
    write_output(text.str());
    return code;
  } catch (const CLI::ParseError& error) {
    return complain(name, exit_usage, std::string{error.what()} + "\nRun with --help for more information.");
  }
  return exit_code;
}

int run_guarded(int argc, char** argv, const char* name, Describe describe) {
  try {
    return io::with_path_errors([&] { return parse_and_run(argc, argv, name, describe); });
  } catch (const ConfigError& error) {
    return complain(name, exit_usage, error.what());
  } catch (const InputError& error) {
    return complain(name, exit_input, error.what());
  } catch (const DeviceError& error) {
    return complain(name, exit_try_again, error.what());
  } catch (const std::bad_alloc&) {
    return complain(name, exit_try_again,
                    "out of memory. Smaller images, a smaller grid or fewer velocities need less.");
  } catch (const std::exception& error) {
    const std::string of_thread{thread_failure(error)};
    if (!of_thread.empty()) return complain(name, exit_try_again, of_thread);
    return complain(name, exit_bug,
                    std::string{"internal error: "} + error.what() +
                        "\nThis is a bug in stereogrid. Please report it with the command line and the input.");
  }
}

}  // namespace

int run_program(int argc, char** argv, const char* name, Describe describe) {
  if (!open_standard_streams()) return exit_try_again;
  set_up_log();
  keep_memory();
  std::signal(SIGXFSZ, SIG_IGN);  // a file above `ulimit -f` then cannot be written, as on a full disk
  const int exit_code{run_guarded(argc, argv, name, describe)};
  const std::string lost{lost_output()};
  if (!lost.empty()) {
    complain(name, exit_try_again, "standard output is not all there (" + lost + "). Send it where there is space.");
  }
  flush_errors();
  const bool is_failure{!lost.empty() && exit_code == exit_done && interrupted() == 0};
  return is_failure ? exit_try_again : exit_code;
}

}  // namespace stereogrid::app
