// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

namespace stereogrid::app::batch {

/// Its file, in the folder where a shard is worked on.
inline constexpr const char* heartbeat_file{"alive"};
/// So old it means that the runner is gone, s.
inline constexpr int heartbeat_lost_s{90};

/// Writes the file every 15 s, so that others see that somebody works there: the time of the file is the file server's,
/// whatever the clocks of the machines say. Trouble with it is nobody's.
class Heartbeat {
 public:
  explicit Heartbeat(std::filesystem::path work);
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;
  ~Heartbeat();

 private:
  void beat() const;

  std::filesystem::path file_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_{false};
  std::thread thread_;
};

}  // namespace stereogrid::app::batch
