// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::diagnostic_msgs {

struct KeyValue {
  static constexpr std::string_view type_name{"diagnostic_msgs/msg/KeyValue"};

  std::string key;
  std::string value;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("key", self.key);
    visit("value", self.value);
  }
};

struct DiagnosticStatus {
  static constexpr std::string_view type_name{"diagnostic_msgs/msg/DiagnosticStatus"};

  std::byte level{0};  ///< 0: fine, 1: warning, 2: error, 3: stale
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("level", self.level);
    visit("name", self.name);
    visit("message", self.message);
    visit("hardware_id", self.hardware_id);
    visit("values", self.values);
  }
};

struct DiagnosticArray {
  static constexpr std::string_view type_name{"diagnostic_msgs/msg/DiagnosticArray"};

  std_msgs::Header header;
  std::vector<DiagnosticStatus> status;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("status", self.status);
  }
};

}  // namespace stereogrid::messages::diagnostic_msgs
