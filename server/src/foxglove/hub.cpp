// SPDX-License-Identifier: Apache-2.0
#include "foxglove/hub.hpp"

#include <algorithm>
#include <utility>

#include "stereogrid/error.hpp"

namespace stereogrid::server {

bool RequestRate::take(Time now, double amount) {
  if (last_ != Time{}) left_ += per_second_ * std::chrono::duration<double>{now - last_}.count();
  last_ = now;
  left_ = std::min(left_, 2 * per_second_);
  if (left_ < amount) return false;
  left_ -= amount;
  return true;
}

Hub::Hub(HubOptions options, Inbox& inbox, Counters& counters)
    : options_{std::move(options)},
      inbox_{inbox},
      counters_{counters},
      parameters_{std::exchange(options_.parameters, {})} {}

void Hub::add_channel(ChannelId id, Channel channel) {
  const Stream& stream{streams_.emplace(id, Stream{std::move(channel), {}, nullptr}).first->second};
  for (auto& [client_id, client] : clients_) send_control(client, advertise({{id, &stream.channel}}));
  graph_changed();
  if (const auto early{early_.extract(id)}) publish(early.mapped());
}

void Hub::remove_channel(ChannelId id) {
  const auto found{streams_.find(id)};
  if (found == streams_.end()) return;
  const std::string topic{found->second.channel.topic};
  for (auto& [client_id, client] : clients_) {
    if (const auto subscribed{client.channels.find(id)}; subscribed != client.channels.end()) {
      unsubscribe(client, client_id, subscribed->second);
    }
    send_control(client, unadvertise(id));
  }
  streams_.erase(found);
  const bool again{
      std::ranges::any_of(streams_, [&](const auto& entry) { return entry.second.channel.topic == topic; })};
  graph_changed(again ? std::string{} : topic);
}

void Hub::publish_all() {
  while (const SharedMessage message{inbox_.take()}) publish(message);
}

// The inbox may be emptied between the first message of a channel and the request to add it. It has no subscribers yet.
void Hub::publish(const SharedMessage& message) {
  const auto found{streams_.find(message->channel)};
  if (found == streams_.end()) {
    early_[message->channel] = message;
    return;
  }
  Stream& stream{found->second};
  if (stream.channel.latched) stream.last = message;
  for (const ClientId id : stream.subscribers) push(clients_.at(id), message);
}

void Hub::push(Client& client, const SharedMessage& message) {
  if (client.closed) return;
  counters_.messages_dropped += client.messages.push(message);
  client.link.wake();
}

void Hub::publish_time(std::uint64_t stamp_ns) {
  for (auto& [id, client] : clients_) {
    client.time_due = stamp_ns;
    client.link.wake();
  }
}

void Hub::publish_status(StatusLevel level, std::string_view text) {
  for (auto& [id, client] : clients_) send_control(client, status(level, text));
}

void Hub::put_parameter(const Parameter& parameter) {
  parameters_.put(parameter);
  parameter_changed(parameter.name);
}

ClientId Hub::join(Link& link) {
  const ClientId id{++last_client_};
  Client& client{clients_.try_emplace(id, link, "client " + std::to_string(id), options_.limits).first->second};
  counters_.clients = clients_.size();
  ++counters_.clients_ever;
  send_control(client, server_info(options_.name, options_.session, {parameters_.size() > 0, options_.sends_time}));
  std::map<ChannelId, const Channel*> channels;
  for (const auto& [channel_id, stream] : streams_) channels.emplace(channel_id, &stream.channel);
  send_control(client, advertise(channels));
  return id;
}

void Hub::leave(ClientId id) {
  const auto found{clients_.find(id)};
  if (found == clients_.end()) return;
  const auto subscriptions{found->second.subscriptions};
  for (const auto& [subscription, channel] : subscriptions) unsubscribe(found->second, id, subscription);
  clients_.erase(found);
  counters_.clients = clients_.size();
  if (!subscriptions.empty()) graph_changed();
}

void Hub::receive(ClientId id, std::string_view bytes, bool binary, RequestRate::Time now) {
  Client& client{clients_.at(id)};
  if (client.closed) return;
  if (!client.rate.take(now)) {
    return close(client, "more than " + std::to_string(options_.limits.requests_per_second) + " requests per second");
  }
  if (!client.byte_rate.take(now, static_cast<double>(bytes.size()))) {
    return close(client, "more than " + std::to_string(options_.limits.request_bytes_per_second) +
                             " bytes of requests per second");
  }
  try {
    if (binary) throw InputError{error_on_binary(bytes)};
    std::visit([&](const auto& request) { handle(id, request); }, parse_request(bytes));
  } catch (const InputError& error) {
    ++counters_.faults;
    report_status(client, StatusLevel::error, error.what(), 1);
    if (++client.faults >= options_.limits.faults) close(client, "too many malformed requests");
  }
}

std::optional<Frame> Hub::next(ClientId id) {
  Client& client{clients_.at(id)};
  if (!client.control.empty()) {
    Frame frame{false, std::move(client.control.front()), nullptr};
    client.control.pop_front();
    client.control_bytes -= frame.head.size();
    return frame;
  }
  if (std::exchange(client.graph_due, false)) return Frame{false, graph_text(client), nullptr};
  if (!client.parameters_due.empty()) {
    return Frame{false, parameters_text(std::exchange(client.parameters_due, {}), std::nullopt), nullptr};
  }
  if (client.time_due) return Frame{true, time_message(*std::exchange(client.time_due, std::nullopt)), nullptr};
  SharedMessage message{client.messages.pop()};
  if (!message) return std::nullopt;
  ++counters_.messages_sent;
  counters_.bytes_sent += message->payload.size();
  std::string head{message_head(client.channels.at(message->channel), message->stamp_ns)};
  return Frame{true, std::move(head), std::move(message)};
}

void Hub::report_status(Client& client, StatusLevel level, const std::string& first, std::size_t count) {
  if (count == 0) return;
  const std::string more{count > 1 ? " (and " + std::to_string(count - 1) + " more of the same request)" : ""};
  send_control(client, status(level, first + more));
}

void Hub::send_control(Client& client, std::string text) {
  if (client.closed) return;
  client.control_bytes += text.size();
  client.control.push_back(std::move(text));
  if (client.control_bytes > options_.limits.control_bytes) return close(client, "replies were not read");
  client.link.wake();
}

void Hub::close(Client& client, const std::string& reason) {
  if (std::exchange(client.closed, true)) return;
  ++counters_.refused;
  client.link.close(close_code::policy, reason);
}

void Hub::graph_changed(const std::string& removed_topic) {
  for (auto& [id, client] : clients_) {
    if (!client.watches_graph) continue;
    if (!removed_topic.empty()) client.removed_topics.insert(removed_topic);
    client.graph_due = true;
    client.link.wake();
  }
}

std::string Hub::graph_text(Client& client) const {
  Graph graph;
  for (const auto& [id, stream] : streams_) {
    std::vector<std::string>& subscribers{graph[stream.channel.topic]};
    for (const ClientId subscriber : stream.subscribers) subscribers.push_back(clients_.at(subscriber).name);
    client.removed_topics.erase(stream.channel.topic);  // there again
  }
  return connection_graph(options_.name, graph, std::exchange(client.removed_topics, {}));
}

void Hub::handle(ClientId id, const Subscribe& request) {
  std::size_t refused{0};
  std::string first;
  for (const Subscription& wanted : request.subscriptions) {
    const std::optional<std::string> why{subscribe(id, wanted)};
    if (why && refused++ == 0) first = *why;
  }
  report_status(clients_.at(id), StatusLevel::warning, first, refused);
  if (refused < request.subscriptions.size()) graph_changed();
}

std::optional<std::string> Hub::subscribe(ClientId id, const Subscription& wanted) {
  Client& client{clients_.at(id)};
  const auto stream{streams_.find(wanted.channel)};
  if (stream == streams_.end()) return "subscribe: there is no channel " + std::to_string(wanted.channel) + ".";
  if (client.subscriptions.contains(wanted.id)) {
    return "subscribe: id " + std::to_string(wanted.id) + " is in use: unsubscribe it first, or choose another one.";
  }
  if (client.channels.contains(wanted.channel)) {
    return "subscribe: channel " + std::to_string(wanted.channel) + " is subscribed already.";
  }
  client.subscriptions.emplace(wanted.id, wanted.channel);
  client.channels.emplace(wanted.channel, wanted.id);
  stream->second.subscribers.insert(id);
  notify_subscribers(wanted.channel);
  if (stream->second.last) push(client, stream->second.last);
  return std::nullopt;
}

void Hub::handle(ClientId id, const Unsubscribe& request) {
  Client& client{clients_.at(id)};
  std::size_t unknown{0};
  std::string first;
  for (const SubscriptionId subscription : request.ids) {
    if (client.subscriptions.contains(subscription)) {
      unsubscribe(client, id, subscription);
    } else if (unknown++ == 0) {
      first = "unsubscribe: there is no subscription " + std::to_string(subscription) + ".";
    }
  }
  report_status(client, StatusLevel::warning, first, unknown);
  if (unknown < request.ids.size()) graph_changed();
}

void Hub::unsubscribe(Client& client, ClientId id, SubscriptionId subscription) {
  const auto found{client.subscriptions.find(subscription)};
  const ChannelId channel{found->second};
  client.subscriptions.erase(found);
  client.channels.erase(channel);
  client.messages.remove(channel);
  streams_.at(channel).subscribers.erase(id);
  notify_subscribers(channel);
}

void Hub::notify_subscribers(ChannelId id) {
  inbox_.set_subscribers(id, streams_.at(id).subscribers.size());
}

void Hub::handle(ClientId id, const GetParameters& request) {
  Client& client{clients_.at(id)};
  std::set<std::string> names;
  std::size_t unknown{0};
  std::string first;
  for (const std::string& name : request.names.empty() ? parameters_.names() : request.names) {
    if (parameters_.find(name) != nullptr) {
      names.insert(name);
    } else if (unknown++ == 0) {
      first = "getParameters: there is no parameter '" + name.substr(0, 60) + "'.";
    }
  }
  report_status(client, StatusLevel::warning, first, unknown);
  send_control(client, parameters_text(names, request.id));
}

void Hub::handle(ClientId id, const SetParameters& request) {
  // each may take the owner's time
  if (request.parameters.size() > parameters_.size()) throw InputError{"setParameters: names more than there are."};
  std::set<std::string> names;
  std::size_t refused{0};
  std::string first;
  for (const Parameter& requested : request.parameters) {
    const std::optional<std::string> why{parameters_.set(requested)};
    if (why && refused++ == 0) first = "setParameters: '" + requested.name.substr(0, 60) + "': " + *why;
    if (!why) parameter_changed(requested.name);
    if (parameters_.find(requested.name) != nullptr) names.insert(requested.name);
  }
  Client& client{clients_.at(id)};
  report_status(client, StatusLevel::error, first, refused);
  if (request.id) send_control(client, parameters_text(names, request.id));
}

void Hub::handle(ClientId id, const SubscribeParameters& request) {
  Client& client{clients_.at(id)};
  for (const std::string& name : request.names.empty() ? parameters_.names() : request.names) {
    if (parameters_.find(name) != nullptr) client.watched_parameters.insert(name);
  }
}

void Hub::handle(ClientId id, const UnsubscribeParameters& request) {
  Client& client{clients_.at(id)};
  if (request.names.empty()) client.watched_parameters.clear();
  for (const std::string& name : request.names) client.watched_parameters.erase(name);
}

void Hub::handle(ClientId id, SubscribeGraph) {
  Client& client{clients_.at(id)};
  client.watches_graph = true;
  client.graph_due = true;
  client.link.wake();
}

void Hub::handle(ClientId id, UnsubscribeGraph) {
  Client& client{clients_.at(id)};
  client.watches_graph = false;
  client.graph_due = false;
  client.removed_topics.clear();
}

void Hub::parameter_changed(const std::string& name) {
  for (auto& [id, client] : clients_) {
    if (!client.watched_parameters.contains(name)) continue;
    client.parameters_due.insert(name);
    client.link.wake();
  }
}

std::string Hub::parameters_text(const std::set<std::string>& names, const std::optional<std::string>& request) const {
  std::vector<const Parameter*> parameters;
  for (const std::string& name : names) parameters.push_back(parameters_.find(name));
  return parameter_values(parameters, request);
}

}  // namespace stereogrid::server
