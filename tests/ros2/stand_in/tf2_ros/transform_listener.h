// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tf2_ros/buffer.h>

namespace tf2_ros {

/// Its subscriptions have the remappings of the node.
class TransformListener {
 public:
  template <class Node>
  TransformListener(Buffer&, Node* node) {
    last_node() = node;
  }
  /// Node of the last one that was made.
  static void*& last_node() {
    static void* node{nullptr};
    return node;
  }
};

}  // namespace tf2_ros
