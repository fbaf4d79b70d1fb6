// SPDX-License-Identifier: Apache-2.0
#pragma once

#define RCLCPP_COMPONENTS_REGISTER_NODE(Class) static_assert(sizeof(Class) > 0);
