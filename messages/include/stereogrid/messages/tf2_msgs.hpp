// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"

namespace stereogrid::messages::tf2_msgs {

struct TFMessage {
  static constexpr std::string_view type_name{"tf2_msgs/msg/TFMessage"};

  std::vector<geometry_msgs::TransformStamped> transforms;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("transforms", self.transforms);
  }
};

}  // namespace stereogrid::messages::tf2_msgs
