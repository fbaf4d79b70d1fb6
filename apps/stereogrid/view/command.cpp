// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "cli/commands.hpp"
#include "cli/console.hpp"
#include "cli/interrupt.hpp"
#include "connect/page.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/server/server.hpp"
#include "view/playback.hpp"
#include "view/recorded_frames.hpp"

namespace stereogrid::app {
namespace {

struct Options {
  std::string recording;
  PageOptions page;
};

server::ServerOptions server_options(const std::filesystem::path& file, Playback& playback) {
  server::ServerOptions made;
  made.name = io::printable_path(file.filename());
  made.sends_time = true;
  made.parameters.values = playback.parameters();
  made.parameters.set = [&playback](const server::Parameter& parameter) { return playback.set(parameter); };
  return made;
}

/// Plays until a stop is requested.
void play(const RecordedFrames& frames, Playback& playback, server::Server& server) {
  using namespace std::chrono_literals;
  std::optional<PlaybackState> shown;
  while (interrupted() == 0) {
    const PlaybackState state{playback.wait(100ms)};
    if (shown == state) continue;
    if (!shown || shown->frame != state.frame) frames.send(static_cast<std::size_t>(state.frame), server);
    for (const server::Parameter& parameter : playback.parameters_of(state)) server.set_parameter(parameter);
    shown = state;
  }
}

int view(const Options& options) {
  const std::filesystem::path file{recording_at(options.recording)};
  RecordedFrames frames{file};
  Playback playback{frames.stamps_ns()};
  const auto server{start_server(options.page, server_options(file, playback))};
  frames.add_channels(*server);
  catch_interrupts();
  for (const std::string& sentence : frames.bag().damage()) tell_on_stderr("warning: {}\n", sentence);
  tell("{} frames; open {}\n", frames.stamps_ns().size(), server->url());
  if (!failed_output().empty()) return exit_try_again;  // run_program() says it
  play(frames, playback, *server);
  return exit_done;
}

}  // namespace

void add_view_command(CLI::App& tool, int& exit_code) {
  auto options{std::make_shared<Options>()};
  CLI::App* command{tool.add_subcommand("view", "Play a recording in the browser; Ctrl-C ends it.")};
  command->add_option("recording", options->recording, "A recording of 'run --mcap', or the folder of that run.")
      ->type_name("FILE.mcap|DIR")
      ->required();
  add_page_options(*command, options->page);
  command->callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace stereogrid::app
