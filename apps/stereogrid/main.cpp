// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>

#include "commands.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/pipeline.hpp"

namespace {

using namespace stereogrid::app;

void set_up_log() {
  auto log{std::make_shared<spdlog::logger>("stereogrid", std::make_shared<spdlog::sinks::stderr_color_sink_mt>())};
  // on a terminal a line first wipes the progress bar that stands there
  const bool terminal{isatty(STDERR_FILENO) == 1};
  log->set_pattern(terminal ? "\r\033[K%^%l%$: %v" : "%l: %v");
  spdlog::set_default_logger(std::move(log));
}

int complain(int exit_code, const std::string& message) {
  fmt::print(stderr, "{}stereogrid: {}\n", isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "", message);
  return exit_code;
}

void describe(CLI::App& tool) {
  tool.description("Stereo camera in, probabilistic occupancy grid with velocities out.");
  tool.footer(
      "INPUT is a KITTI odometry sequence, a KITTI raw drive, a plain folder (left/ right/ calibration.yaml),\n"
      "LEFT.png RIGHT.png with --calibration, or a built-in scene such as 'scene:street?frames=60&seed=3'.\n\n"
      "Exit codes: 0 done, 64 wrong usage, 65 bad input, 70 a bug, 75 try again (disk full, device missing),\n"
      "130 stopped with Ctrl-C (go on with --resume).\n\n"
      "Examples:\n"
      "  stereogrid run scene:street --out /tmp/street --pictures\n"
      "  stereogrid run drives/0009 --out runs/0009 --set grid.length_m=30 --video runs/0009.mp4\n"
      "  stereogrid info drives/0009");
  tool.set_version_flag("--version", "stereogrid " + std::string{stereogrid::version()});
  tool.require_subcommand(0, 1);
  tool.add_flag_callback(
          "-q,--quiet", [] { spdlog::set_level(spdlog::level::warn); }, "Warnings and errors only.")
      ->trigger_on_parse();
  tool.add_flag_callback(
          "-v,--verbose", [] { spdlog::set_level(spdlog::level::debug); }, "Tell every detail.")
      ->trigger_on_parse();
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

int run_tool(int argc, char** argv) {
  CLI::App tool;
  int exit_code{exit_done};
  describe(tool);
  add_run_command(tool, exit_code);
  add_simulate_command(tool, exit_code);
  add_evaluate_command(tool, exit_code);
  add_compare_command(tool, exit_code);
  add_figures_command(tool, exit_code);
  add_info_command(tool, exit_code);
  add_config_command(tool);
  for (CLI::App* command : tool.get_subcommands({})) command->fallthrough();
  try {
    tool.parse(argc, argv);
    if (tool.get_subcommands().empty()) throw CLI::RequiredError{"A sub-command"};
  } catch (const CLI::Success& help_or_version) {
    return tool.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    return complain(exit_usage, std::string{error.what()} + "\nRun with --help for more information.");
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  set_up_log();
  keep_memory();
  std::signal(SIGXFSZ, SIG_IGN);  // a file above `ulimit -f` then cannot be written, as on a full disk
  try {
    return run_tool(argc, argv);
  } catch (const stereogrid::ConfigError& error) {
    return complain(exit_usage, error.what());
  } catch (const stereogrid::InputError& error) {
    return complain(exit_input, error.what());
  } catch (const stereogrid::DeviceError& error) {
    return complain(exit_try_again, error.what());
  } catch (const std::filesystem::filesystem_error& error) {  // such as links that go in a circle
    return complain(exit_input, fmt::format("{}: {}. Check the path and its permissions.",
                                            stereogrid::io::printable_path(error.path1()), error.code().message()));
  } catch (const std::bad_alloc&) {
    return complain(exit_try_again, "out of memory. Smaller images, a smaller grid or fewer velocities need less.");
  } catch (const std::exception& error) {
    return complain(exit_bug,
                    std::string{"internal error: "} + error.what() +
                        "\nThis is a bug in stereogrid. Please report it with the command line and the input.");
  }
}
