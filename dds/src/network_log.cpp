// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "network_node.hpp"

#include <dds/ddsrt/log.h>

#include <mutex>
#include <set>
#include <string_view>
#include <utility>

namespace stereogrid::dds {
namespace {

constexpr std::size_t told_max{1000};
// normal, and harmless: discovery works without multicast
constexpr std::string_view loopback{"selected interface \"lo\" is not multicast-capable"};

struct Log {
  std::mutex mutex;
  std::function<void(const std::string&)> warn;
  std::set<std::string> told;
};

Log& log_of_process() {
  static Log log;
  return log;
}

std::string without_digits(std::string text) {
  std::erase_if(text, [](char letter) { return letter >= '0' && letter <= '9'; });
  return text;
}

// No exceptions: called by C.
void take(void* /*of*/, const dds_log_data_t* data) noexcept {
  if ((data->priority & (DDS_LC_FATAL | DDS_LC_ERROR | DDS_LC_WARNING)) == 0) return;
  try {
    std::string text{data->message};
    std::erase_if(text, [](unsigned char letter) { return letter < ' '; });  // the text may include data of a peer
    if (text.starts_with(loopback)) return;
    Log& log{log_of_process()};
    std::function<void(const std::string&)> warn;
    {
      const std::scoped_lock lock{log.mutex};
      if (log.told.size() < told_max && log.told.insert(without_digits(text)).second) warn = log.warn;
    }
    if (warn) warn("ROS 2: " + text);
  } catch (...) {
  }
}

}  // namespace

void take_network_log(std::function<void(const std::string&)> warn) {
  Log& log{log_of_process()};
  const std::scoped_lock lock{log.mutex};
  log.warn = std::move(warn);
  log.told.clear();
  dds_set_log_sink(take, nullptr);
}

}  // namespace stereogrid::dds
