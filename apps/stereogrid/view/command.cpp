// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "stereogrid/server/server.hpp"
#include "view/playback.hpp"

namespace stereogrid::app {
namespace {

/// Messages to the page, all of them latched and wanted: the player may stand still before a viewer comes.
class LatchedSink final : public messages::Sink {
 public:
  explicit LatchedSink(server::Server& server) : viewers_{viewer_sink(server)} {}

  std::uint32_t add(const messages::Channel& channel) override {
    const auto found{std::ranges::find(topics_, channel.topic)};
    if (found != topics_.end()) return static_cast<std::uint32_t>(found - topics_.begin());
    topics_.push_back(channel.topic);
    messages::Channel latched{channel};
    latched.latched = true;
    return viewers_->add(latched);
  }
  [[nodiscard]] bool wants(std::uint32_t) const override { return true; }
  void send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) override {
    viewers_->send(channel, stamp_ns, cdr);
  }

 private:
  std::unique_ptr<messages::Sink> viewers_;
  std::vector<std::string> topics_;
};

struct ViewOptions {
  std::vector<std::string> recordings;
  PageOptions page;
};

server::ServerOptions server_options(const std::string& name, Playback& playback) {
  server::ServerOptions made;
  made.name = name;
  made.sends_time = true;
  made.parameters.values = playback.parameters();
  made.parameters.set = [&playback](const server::Parameter& parameter) { return playback.set(parameter); };
  return made;
}

/// Plays until a stop is requested.
void play(PlayedFrames& frames, Playback& playback, server::Server& server) {
  using namespace std::chrono_literals;
  LatchedSink sink{server};
  std::optional<PlaybackState> shown;
  while (interrupted() == 0) {
    const PlaybackState state{playback.wait(100ms)};
    if (shown == state) continue;
    if (!shown || shown->frame != state.frame) {
      const auto frame = static_cast<std::size_t>(state.frame);
      server.send_time(frames.stamps_ns().at(frame));
      frames.send(frame, sink);
    }
    for (const server::Parameter& parameter : playback.parameters_of(state)) server.set_parameter(parameter);
    shown = state;
  }
}

int view(const ViewOptions& options) {
  const std::unique_ptr<PlayedFrames> frames{played_frames(options.recordings)};
  Playback playback{frames->stamps_ns()};
  const auto server{start_server(options.page, server_options(recording_names(options.recordings), playback))};
  catch_interrupts();
  for (const std::string& sentence : frames->damage()) log_on_stderr("warning: {}\n", sentence);
  print("{} frames; open {}\n", frames->stamps_ns().size(), server->url());
  if (!failed_output().empty()) return exit_try_again;  // run_program() says it
  play(*frames, playback, *server);
  return exit_done;
}

}  // namespace

void add_view_command(Command tool, int& exit_code) {
  auto options{std::make_shared<ViewOptions>()};
  const Command command{tool.add_command(
      "view", "Play a run or a recording in the browser; Ctrl-C ends it. Several are shown side by side.")};
  command
      .add_option("RUN", options->recordings,
                  "Folder of 'run --out', or a recording of 'run --mcap' (FILE.mcap). Further ones follow the first by "
                  "stamp.")
      .required();
  add_page_options(command, options->page);
  command.callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace stereogrid::app
