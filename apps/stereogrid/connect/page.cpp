// SPDX-License-Identifier: Apache-2.0
#include "connect/page.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "cli/program.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/server/metrics.hpp"

namespace stereogrid::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds healthy_for{5};  // after a frame
constexpr int service_unavailable{503};

}  // namespace

ListenAddress listen_address_of(const std::string& text) {
  ListenAddress made;
  const std::size_t colon{text.rfind(':')};
  const char* const end{text.data() + text.size()};
  const char* const digits{colon == std::string::npos ? end : text.data() + colon + 1};
  const auto [stop, error]{std::from_chars(digits, end, made.port)};
  std::string address{text.substr(0, colon == std::string::npos ? 0 : colon)};
  const bool bracketed{address.size() > 2 && address.front() == '[' && address.back() == ']'};
  if (bracketed) address = address.substr(1, address.size() - 2);
  const bool ambiguous{!bracketed && address.find(':') != std::string::npos};
  if (error != std::errc{} || stop != end || ambiguous) {
    throw ConfigError{"'" + text +
                      "' is not a place to listen. Give ADDRESS:PORT, such as 127.0.0.1:8765 or [::1]:8765; port 0 "
                      "takes any free one."};
  }
  if (!address.empty()) made.address = address;
  return made;
}

void add_page_options(Command command, PageOptions& options) {
  command.group(Group::page);
  command
      .add_option("--listen ADDRESS:PORT", options.listen,
                  "Address of the page. On an address other than loopback its link has a token, without which access "
                  "is denied. Port 0: any free port.")
      .show_default();
  command.add_option("--allow-origin URL,URL,...", options.allowed_origins,
                     "Origins of other sites with access to the results, such as https://app.foxglove.dev.");
}

std::unique_ptr<server::Server> start_server(const PageOptions& options, server::ServerOptions made) {
  const ListenAddress listen{listen_address_of(options.listen)};
  made.address = listen.address;
  made.port = listen.port;
  made.allowed_origins = options.allowed_origins;
  made.http.assets = viewer_assets();
  try {
    return std::make_unique<server::Server>(std::move(made));
  } catch (const DeviceError& error) {
    throw DeviceError{fmt::format("{} --listen :0 takes any free port.", error.what())};
  }
}

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at{text.find(what)}; at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

std::string embedded_json(std::string json) {
  replace_all(json, "<", "\\u003c");
  return json;
}

struct Page::State {
  [[nodiscard]] server::Answer health() const;
  [[nodiscard]] server::Answer metrics() const;
  void write_counts(server::Metrics& metrics) const;
  void write_times(server::Metrics& metrics) const;

  mutable std::mutex mutex;  // protects the members below, except the server
  std::string fault;
  std::optional<Clock::time_point> last_frame;
  StageTimes times;
  std::size_t obstacles{0};
  std::int64_t frames{0};
  std::optional<messages::Latency> latency;
  std::vector<messages::Dropped> dropped;
  std::unique_ptr<server::Server> server;  // its thread uses the members above
};

server::Answer Page::State::health() const {
  const std::scoped_lock lock{mutex};
  if (!fault.empty()) return {service_unavailable, "text/plain; charset=utf-8", fault + "\n"};
  if (!last_frame) return {service_unavailable, "text/plain; charset=utf-8", "No frame is done yet.\n"};
  const auto since{Clock::now() - *last_frame};
  if (since <= healthy_for) return {.body = "fine\n"};
  return {service_unavailable, "text/plain; charset=utf-8",
          fmt::format("The last frame was {:.0f} s ago.\n", std::chrono::duration<double>{since}.count())};
}

void Page::State::write_counts(server::Metrics& metrics) const {
  metrics.counter("stereogrid_frames_total", "Frames that became grids.");
  metrics.sample(static_cast<double>(frames));
  metrics.counter("stereogrid_frames_dropped_total", "Frames that did not, and why.");
  for (const messages::Dropped& one : dropped) {
    metrics.sample(static_cast<double>(one.frames), {{"reason", one.reason}});
  }
  metrics.gauge("stereogrid_obstacles", "Confirmed obstacles in the last frame.");
  metrics.sample(static_cast<double>(obstacles));
}

void Page::State::write_times(server::Metrics& metrics) const {
  constexpr double seconds_per_ms{1e-3};
  metrics.gauge("stereogrid_stage_seconds", "Time that each stage took for the last frame.");
  for (const io::StageField& stage : io::stage_fields) {
    metrics.sample(times.*stage.milliseconds * seconds_per_ms, {{"stage", std::string{stage.name}}});
  }
  if (!latency) return;
  metrics.gauge("stereogrid_latency_seconds", "From exposure to grid, of the last frames.");
  metrics.sample(latency->median * seconds_per_ms, {{"quantile", "0.5"}});
  metrics.sample(latency->p99 * seconds_per_ms, {{"quantile", "0.99"}});
}

server::Answer Page::State::metrics() const {
  server::Metrics metrics;
  const std::scoped_lock lock{mutex};
  write_counts(metrics);
  write_times(metrics);
  if (server) {
    const server::ServerCounts counts{server->counts()};
    metrics.gauge("stereogrid_viewers", "Clients that are connected by WebSocket.");
    metrics.sample(static_cast<double>(counts.clients));
    metrics.counter("stereogrid_messages_sent_total", "Messages sent, to each client.");
    metrics.sample(static_cast<double>(counts.messages_sent));
    metrics.counter("stereogrid_messages_dropped_total", "Messages for clients that were too slow.");
    metrics.sample(static_cast<double>(counts.messages_dropped));
  }
  return {.content_type = server::Metrics::content_type, .body = metrics.text()};
}

Page::Page(const PageOptions& options, std::string name, server::Parameters parameters)
    : state_{std::make_unique<State>()} {
  server::ServerOptions made;
  made.name = std::move(name);
  made.parameters = std::move(parameters);
  made.http.endpoints.push_back({"/healthz", [state = state_.get()] { return state->health(); }});
  made.http.endpoints.push_back({"/metrics", [state = state_.get()] { return state->metrics(); }});
  auto server{start_server(options, std::move(made))};
  const std::scoped_lock lock{state_->mutex};  // requests may have arrived already
  state_->server = std::move(server);
}

Page::~Page() = default;

server::Server& Page::server() {
  return *state_->server;
}

void Page::note(const FrameResult& result, const messages::FrameFacts& facts) {
  const std::scoped_lock lock{state_->mutex};
  state_->last_frame = Clock::now();
  state_->times = result.timing_ms;
  state_->obstacles = result.obstacles.size();
  state_->dropped.assign(facts.dropped.begin(), facts.dropped.end());
  state_->frames = facts.frames;
  state_->latency = facts.latency;
}

void Page::set_fault(const std::string& sentence) {
  {
    const std::scoped_lock lock{state_->mutex};
    if (state_->fault == sentence) return;
    state_->fault = sentence;
  }
  const bool is_fine{sentence.empty()};
  server().send_status(is_fine ? server::StatusLevel::info : server::StatusLevel::warning,
                       is_fine ? "It works again." : sentence);
}

}  // namespace stereogrid::app
