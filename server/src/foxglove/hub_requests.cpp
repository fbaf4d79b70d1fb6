// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// What clients ask for.

#include "foxglove/hub.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::server {

void Hub::handle(ClientId id, const Subscribe& request) {
  std::size_t refused{0};
  std::string first;
  for (const Subscription& wanted : request.subscriptions) {
    const std::optional<std::string> why{subscribe(id, wanted)};
    if (why && refused++ == 0) first = *why;
  }
  complain(clients_.at(id), StatusLevel::warning, first, refused);
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
  complain(client, StatusLevel::warning, first, unknown);
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
  complain(client, StatusLevel::warning, first, unknown);
  send_control(client, parameters_text(names, request.id));
}

void Hub::handle(ClientId id, const SetParameters& request) {
  // each may take the owner's time
  if (request.parameters.size() > parameters_.size()) throw InputError{"setParameters: names more than there are."};
  std::set<std::string> names;
  std::size_t refused{0};
  std::string first;
  for (const Parameter& wish : request.parameters) {
    const std::optional<std::string> why{parameters_.set(wish)};
    if (why && refused++ == 0) first = "setParameters: '" + wish.name.substr(0, 60) + "': " + *why;
    if (!why) parameter_changed(wish.name);
    if (parameters_.find(wish.name) != nullptr) names.insert(wish.name);
  }
  Client& client{clients_.at(id)};
  complain(client, StatusLevel::error, first, refused);
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
