// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/definition.hpp"
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::messages {

/// A topic and its message, whose memory is reused.
template <Message M>
struct Topic {
  std::string path;
  bool is_latched{false};
  bool is_selected{true};
  M message{};
  std::optional<std::uint32_t> channel{};  // empty: not yet added to the publisher
};

/// Encodes messages of topics with receivers into one buffer.
class Outlet {
 public:
  /// `selected`: names of topics; empty: all.
  Outlet(Sink& sink, std::string node, std::vector<std::string> selected)
      : sink_{&sink}, node_{std::move(node)}, selected_{std::move(selected)} {}

  /// `name` begins with "/": a topic of the root, else of the node; `suffix` belongs to the path only.
  template <Message M>
  Topic<M> topic(std::string_view name, bool is_latched = false, const std::string& suffix = {}) {
    const bool is_of_root{name.starts_with('/')};
    const std::string of_node{is_of_root ? "" : "/" + node_ + "/"};
    if (is_of_root) name.remove_prefix(1);
    return {(is_of_root ? "/" : of_node) + std::string{name} + suffix, is_latched, select(name)};
  }

  /// Topic of one of several cameras, below its name; selected by `name` alone. "": of the only camera.
  template <Message M>
  Topic<M> camera_topic(const std::string& camera, std::string_view name) {
    return {"/" + node_ + "/" + (camera.empty() ? "" : camera + "/") + std::string{name}, false, select(name)};
  }

  /// Throws ConfigError: a selected name is none of the topics made so far.
  void check_selection() const;

  /// True if the topic has receivers. Adds it to the publisher.
  template <Message M>
  bool wants(Topic<M>& topic) {
    if (!topic.is_selected) return false;
    if (!topic.channel) topic.channel = sink_->add({topic.path, M::type_name, definition_of<M>(), topic.is_latched});
    return sink_->wants(*topic.channel);
  }

  /// Calls `fill` with the message and sends it, if the topic has receivers. Returns true if it was sent.
  template <Message M, class Fill>
  bool offer(Topic<M>& topic, std::int64_t stamp_ns, Fill&& fill) {
    if (!wants(topic)) return false;
    fill(topic.message);
    sink_->send(*topic.channel, stamp_ns, writer_.encode(topic.message));
    return true;
  }

 private:
  bool select(std::string_view name);

  Sink* sink_;
  std::string node_;
  std::vector<std::string> selected_;
  std::vector<std::string> known_;
  CdrWriter writer_;
};

}  // namespace stereogrid::messages
