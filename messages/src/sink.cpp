// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/sink.hpp"

#include <algorithm>
#include <utility>

#include "outlet.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::messages {

Sink::~Sink() = default;

Tee::Tee(std::vector<Sink*> sinks) : sinks_{std::move(sinks)} {}

std::uint32_t Tee::add(const Channel& channel) {
  std::vector<std::uint32_t>& numbers{channels_.emplace_back()};
  for (Sink* const sink : sinks_) numbers.push_back(sink->add(channel));
  return static_cast<std::uint32_t>(channels_.size() - 1);
}

bool Tee::wants(std::uint32_t channel) const {
  for (std::size_t i{0}; i < sinks_.size(); ++i) {
    if (sinks_[i]->wants(channels_.at(channel)[i])) return true;
  }
  return false;
}

void Tee::send(std::uint32_t channel, std::int64_t stamp_ns, std::span<const std::byte> cdr) {
  for (std::size_t i{0}; i < sinks_.size(); ++i) {
    const std::uint32_t number{channels_.at(channel)[i]};
    if (sinks_[i]->wants(number)) sinks_[i]->send(number, stamp_ns, cdr);
  }
}

bool Outlet::select(std::string_view name) {
  if (std::ranges::find(known_, name) == known_.end()) known_.emplace_back(name);
  return selected_.empty() || std::ranges::find(selected_, name) != selected_.end();
}

void Outlet::check_selection() const {
  for (const std::string& name : selected_) {
    if (std::ranges::find(known_, name) != known_.end()) continue;
    std::string text{"There is no topic \"" + name + "\". There are:"};
    for (const std::string& known : known_) text += " " + known;
    throw ConfigError{text};
  }
}

}  // namespace stereogrid::messages
