// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ros2/waiting.hpp"

#include <spdlog/spdlog.h>

#include <thread>

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;

constexpr auto look_every{50ms};
constexpr auto tell_after{2s};

}  // namespace

void Waiting::tell(const std::string& sentence) {
  if (sentence != sentence_) {
    sentence_ = sentence;
    since_ = Clock::now();
  } else if (Clock::now() - since_ > tell_after && told_ != sentence) {
    spdlog::warn("waiting: {}", sentence);
    told_ = sentence;
  }
  std::this_thread::sleep_for(look_every);
}

NewestMessages::~NewestMessages() {
  std::map<std::string, std::vector<std::byte>> messages;
  {
    const std::scoped_lock lock{state_->mutex};
    messages.swap(state_->messages);
  }
  for (const auto& [topic, ignored] : messages) node_.unsubscribe(topic);
}

void NewestMessages::add(const mcap::Topic& topic) {
  {
    const std::scoped_lock lock{state_->mutex};
    if (!state_->messages.try_emplace(topic.name).second) return;
  }
  node_.subscribe(topic.name, topic.type, 1, [state = state_, name = topic.name](std::span<const std::byte> cdr) {
    const std::scoped_lock lock{state->mutex};
    const auto found{state->messages.find(name)};
    if (found != state->messages.end()) found->second.assign(cdr.begin(), cdr.end());
  });
}

std::optional<std::vector<std::byte>> NewestMessages::of(const std::string& topic) const {
  const std::scoped_lock lock{state_->mutex};
  const auto found{state_->messages.find(topic)};
  if (found == state_->messages.end() || found->second.empty()) return std::nullopt;
  return found->second;
}

}  // namespace stereogrid::app
