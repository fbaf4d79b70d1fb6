// SPDX-License-Identifier: Apache-2.0
#include "foxglove/message_queue.hpp"

#include <algorithm>
#include <utility>

namespace stereogrid::server {
namespace {

std::size_t size_of(const Message& message) {
  return sizeof(Message) + message.payload.size();
}

}  // namespace

std::size_t MessageQueue::push(SharedMessage message) {
  const std::size_t size{size_of(*message)};
  const auto share_of{[&] {
    const auto found{shares_.find(message->channel)};
    return found == shares_.end() ? Share{} : found->second;
  }};
  std::size_t dropped{0};
  for (; share_of().messages >= limits_.messages; ++dropped) drop_oldest(message->channel);
  for (; !messages_.empty() && bytes_ + size > limits_.bytes; ++dropped) {
    drop_oldest(share_of().messages > 0 ? message->channel : largest());
  }
  Share& share{shares_[message->channel]};
  ++share.messages;
  share.bytes += size;
  bytes_ += size;
  messages_.push_back(std::move(message));
  return dropped;
}

SharedMessage MessageQueue::pop() {
  if (messages_.empty()) return nullptr;
  SharedMessage message{std::move(messages_.front())};
  messages_.pop_front();
  count_out(*message);
  return message;
}

void MessageQueue::remove(ChannelId channel) {
  while (shares_.contains(channel)) drop_oldest(channel);
}

void MessageQueue::count_out(const Message& message) {
  const std::size_t size{size_of(message)};
  const auto share{shares_.find(message.channel)};
  share->second.bytes -= size;
  bytes_ -= size;
  if (--share->second.messages == 0) shares_.erase(share);
}

void MessageQueue::drop_oldest(ChannelId channel) {
  const auto oldest{std::ranges::find(messages_, channel, [](const SharedMessage& one) { return one->channel; })};
  count_out(**oldest);
  messages_.erase(oldest);
}

ChannelId MessageQueue::largest() const {
  return std::ranges::max_element(shares_, {}, [](const auto& entry) { return entry.second.bytes; })->first;
}

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
  return !std::exchange(is_reported_, true);
}

SharedMessage Inbox::take() {
  const std::lock_guard lock{mutex_};
  is_reported_ = !queue_.empty();
  return queue_.pop();
}

}  // namespace stereogrid::server
