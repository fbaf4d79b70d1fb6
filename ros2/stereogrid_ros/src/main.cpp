// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Copyright 2026 The stereogrid authors
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.
#include <cstdio>
#include <exception>
#include <memory>

#include <rclcpp/rclcpp.hpp>

#include "stereo_grid_node.hpp"

/// The component in a process of its own. Exit code 1: wrong parameters, or the pipeline has failed.
int main(int argc, char** argv) {
  bool has_failed{false};
  try {
    rclcpp::init(argc, argv);
    const auto node{std::make_shared<stereogrid_ros::StereoGridNode>()};
    node->set_failure_handler([] { rclcpp::shutdown(); });  // a process that does nothing is not left in the graph
    if (!node->has_failed()) rclcpp::spin(node->get_node_base_interface());
    has_failed = node->has_failed();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stereo_grid: %s\n", error.what());
    has_failed = true;
  }
  rclcpp::shutdown();
  return has_failed ? 1 : 0;
}
