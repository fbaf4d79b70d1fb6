// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "participant.hpp"

namespace stereogrid::dds {

/// Passes received messages to subscribers on one thread, so that threads of the network do not wait.
class Subscriptions {
 public:
  explicit Subscriptions(Participant& participant);
  Subscriptions(const Subscriptions&) = delete;
  Subscriptions& operator=(const Subscriptions&) = delete;
  ~Subscriptions();

  void add(const std::string& topic, const std::string& type, std::size_t depth, Take take, bool is_latched);
  void remove(const std::string& topic);

 private:
  struct Reader {
    std::string topic;
    Take take;
    std::atomic<dds_entity_t> entity{0};  // 0: removed; the thread may still have the address
  };

  void run();
  void take_all(const Reader& reader);
  void hand_over(const Reader& reader, std::span<const std::byte> cdr);

  Participant& participant_;
  dds_entity_t waitset_;
  dds_entity_t stop_;
  std::mutex mutex_;  // guards `readers_`
  std::vector<std::unique_ptr<Reader>> readers_;
  std::thread thread_;
};

}  // namespace stereogrid::dds
