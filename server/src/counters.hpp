// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

namespace stereogrid::server {

/// Sources of ServerCounts; counted on the server's thread and on those that send.
struct Counters {
  std::atomic<std::size_t> clients{0};
  std::atomic<std::uint64_t> clients_ever{0};
  std::atomic<std::uint64_t> messages_sent{0};
  std::atomic<std::uint64_t> bytes_sent{0};
  std::atomic<std::uint64_t> messages_dropped{0};
  std::atomic<std::uint64_t> faults{0};
  std::atomic<std::uint64_t> refused{0};
  std::atomic<std::uint64_t> http_requests{0};
};

}  // namespace stereogrid::server
