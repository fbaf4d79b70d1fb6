// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::diagnostic_msgs {

struct KeyValue {
  STEREOGRID_MESSAGE("diagnostic_msgs/msg/KeyValue", key, value);

  std::string key;
  std::string value;
};

struct DiagnosticStatus {
  STEREOGRID_MESSAGE("diagnostic_msgs/msg/DiagnosticStatus", level, name, message, hardware_id, values);

  std::byte level{0};  ///< 0: fine, 1: warning, 2: error, 3: stale
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;
};

struct DiagnosticArray {
  STEREOGRID_MESSAGE("diagnostic_msgs/msg/DiagnosticArray", header, status);

  std_msgs::Header header;
  std::vector<DiagnosticStatus> status;
};

}  // namespace stereogrid::messages::diagnostic_msgs
