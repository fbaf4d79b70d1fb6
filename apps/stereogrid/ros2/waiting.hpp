// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/dds/node.hpp"
#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::app {

/// Logs a wait that lasts.
class Waiting {
 public:
  void tell(const std::string& sentence);

 private:
  using Clock = std::chrono::steady_clock;

  std::string sentence_;
  std::string told_;
  Clock::time_point since_{Clock::now()};
};

/// Newest message of each topic; subscribed for the lifetime of this object.
class NewestMessages {
 public:
  explicit NewestMessages(dds::Node& node) : node_{node} {}
  NewestMessages(const NewestMessages&) = delete;
  NewestMessages& operator=(const NewestMessages&) = delete;
  ~NewestMessages();

  /// A topic that has been added already: no effect.
  void add(const mcap::Topic& topic);
  [[nodiscard]] std::optional<std::vector<std::byte>> of(const std::string& topic) const;

 private:
  struct State {
    std::mutex mutex;
    std::map<std::string, std::vector<std::byte>> messages;  // empty: none yet
  };

  dds::Node& node_;
  std::shared_ptr<State> state_{std::make_shared<State>()};  // the node has it, too
};

}  // namespace stereogrid::app
