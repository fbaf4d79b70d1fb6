// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/messages/geometry_msgs.hpp"

namespace stereogrid::messages::tf2_msgs {

struct TFMessage {
  STEREOGRID_MESSAGE("tf2_msgs/msg/TFMessage", transforms);

  std::vector<geometry_msgs::TransformStamped> transforms;
};

}  // namespace stereogrid::messages::tf2_msgs
