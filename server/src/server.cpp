// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/server/server.hpp"

#include <pthread.h>

#include <atomic>
#include <csignal>
#include <thread>
#include <utility>

#include "foxglove/hub.hpp"
#include "foxglove/message_queue.hpp"
#include "http/site.hpp"
#include "net/network.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::server {
namespace {

void check(const Limits& limits) {
  using namespace std::chrono_literals;
  const bool fine{limits.clients > 0 && limits.connections > 0 && limits.queue_messages > 0 &&
                  limits.request_bytes > 0 && limits.requests_per_second > 0 && limits.faults > 0 &&
                  limits.connections_per_address > 0 && limits.request_bytes_per_second > 0 &&
                  limits.http_timeout > 0ms && limits.idle_timeout > 0ms};
  if (!fine) throw ConfigError{"The server's limits have to be above 0."};
}

ServerOptions checked(ServerOptions options) {
  check(options.limits);
  if (!options.token.empty()) check_token(options.token);
  return options;
}

AccessRules rules_of(const ServerOptions& options, const Network& network) {
  const bool made_up{options.token.empty() && !network.loopback()};
  return {network.loopback(), network.address(), made_up ? random_token() : options.token,
          "stereogrid_token_" + std::to_string(network.port()),  // browsers do not distinguish ports
          options.allowed_origins};
}

/// A thread that leaves signals to the program's other ones.
template <class Work>
std::thread quiet_thread(Work work) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  struct Restore {
    const sigset_t& mask;
    ~Restore() { pthread_sigmask(SIG_SETMASK, &mask, nullptr); }
  } const restore{before};
  return std::thread{std::move(work)};
}

}  // namespace

struct Server::State {
  explicit State(ServerOptions given)
      : options{checked(std::move(given))},
        network{options.address, options.port},
        rules{rules_of(options, network)},
        site{std::move(options.http), rules},
        inbox{{options.limits.queue_bytes, options.limits.queue_messages}, counters},
        hub{{options.name, random_token(), options.sends_time, std::move(options.parameters), options.limits},
            inbox,
            counters},
        port{network.port()},
        url{"http://" + rules.address + ":" + std::to_string(port) + "/" +
            (rules.token.empty() ? "" : "?token=" + rules.token)} {
    thread = quiet_thread([this] { network.run(hub, site, options.limits, counters); });
  }

  ServerOptions options;
  Counters counters;
  Network network;
  AccessRules rules;
  Site site;
  Inbox inbox;
  Hub hub;
  std::uint16_t port;
  std::string url;
  std::atomic<ChannelId> last_channel{0};
  std::thread thread;
};

Server::Server(ServerOptions options) : state_{std::make_unique<State>(std::move(options))} {}

Server::~Server() {
  state_->network.stop();
  state_->thread.join();
}

std::uint16_t Server::port() const {
  return state_->port;
}

const std::string& Server::token() const {
  return state_->rules.token;
}

const std::string& Server::url() const {
  return state_->url;
}

ChannelId Server::add_channel(Channel channel) {
  const ChannelId id{++state_->last_channel};
  state_->inbox.open(id, channel.latched);
  state_->network.post(
      [state = state_.get(), id, channel = std::move(channel)] { state->hub.add_channel(id, channel); });
  return id;
}

void Server::remove_channel(ChannelId id) {
  state_->inbox.close(id);
  state_->network.post([state = state_.get(), id] { state->hub.remove_channel(id); });
}

bool Server::wanted(ChannelId id) const {
  return state_->inbox.wanted(id);
}

void Server::send(ChannelId id, std::uint64_t stamp_ns, std::span<const std::byte> message) {
  if (!wanted(id)) return;
  const bool first{
      state_->inbox.put(std::make_shared<const Message>(Message{id, stamp_ns, {message.begin(), message.end()}}))};
  if (first) state_->network.post([state = state_.get()] { state->hub.publish_all(); });
}

void Server::send_time(std::uint64_t stamp_ns) {
  state_->network.post([state = state_.get(), stamp_ns] { state->hub.publish_time(stamp_ns); });
}

void Server::send_status(StatusLevel level, std::string_view text) {
  state_->network.post(
      [state = state_.get(), level, text = std::string{text}] { state->hub.publish_status(level, text); });
}

void Server::set_parameter(const Parameter& parameter) {
  state_->hub.parameters().check(parameter);
  state_->network.post([state = state_.get(), parameter] { state->hub.put_parameter(parameter); });
}

ServerCounts Server::counts() const {
  const Counters& now{state_->counters};
  return {now.clients,          now.clients_ever, now.messages_sent, now.bytes_sent,
          now.messages_dropped, now.faults,       now.refused,       now.http_requests};
}

}  // namespace stereogrid::server
