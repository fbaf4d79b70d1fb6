// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/heartbeat.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "batch/results.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app::batch {

Heartbeat::Heartbeat(std::filesystem::path work) : file_{std::move(work) / heartbeat_file} {
  beat();
  thread_ = std::thread{[this] {
    std::unique_lock lock{mutex_};
    while (!changed_.wait_for(lock, std::chrono::seconds{15}, [this] { return ended_; })) beat();
  }};
}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock{mutex_};
    ended_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Heartbeat::beat() const {
  try {
    io::write_file(file_, fmt::format("{} {}\n", host_name(), getpid()));
  } catch (const DeviceError&) {
    return;  // a full disk: the run itself tells of it
  }
}

}  // namespace stereogrid::app::batch
