// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "foxglove/inbox.hpp"

#include <utility>

namespace stereogrid::server {

void Inbox::open(ChannelId channel, bool latched) {
  const std::lock_guard lock{mutex_};
  channels_[channel] = {latched, 0};
}

void Inbox::close(ChannelId channel) {
  const std::lock_guard lock{mutex_};
  channels_.erase(channel);
  queue_.remove(channel);
}

void Inbox::set_subscribers(ChannelId channel, std::size_t count) {
  const std::lock_guard lock{mutex_};
  if (const auto found{channels_.find(channel)}; found != channels_.end()) found->second.subscribers = count;
}

bool Inbox::wanted(ChannelId channel) const {
  const std::lock_guard lock{mutex_};
  const auto found{channels_.find(channel)};
  return found != channels_.end() && (found->second.latched || found->second.subscribers > 0);
}

bool Inbox::put(SharedMessage message) {
  const std::lock_guard lock{mutex_};
  if (!channels_.contains(message->channel)) return false;
  counters_.messages_dropped += queue_.push(std::move(message));
  return !std::exchange(told_, true);
}

SharedMessage Inbox::take() {
  const std::lock_guard lock{mutex_};
  told_ = !queue_.empty();
  return queue_.pop();
}

}  // namespace stereogrid::server
