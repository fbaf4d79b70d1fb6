// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav2_costmap_2d {

constexpr unsigned char NO_INFORMATION{255};
constexpr unsigned char LETHAL_OBSTACLE{254};
constexpr unsigned char INSCRIBED_INFLATED_OBSTACLE{253};
constexpr unsigned char FREE_SPACE{0};

}  // namespace nav2_costmap_2d
