// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/pipeline.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {

/// Small images, mostly of a camera that could be.
[[nodiscard]] Rig choose_rig(Choices& choices);

/// A preset with some parameters changed, mostly within their ranges.
[[nodiscard]] Config choose_config(Choices& choices);

/// True: it takes no more memory and time than a try may.
[[nodiscard]] bool is_small(const Config& config);

/// Mostly one that fits the rig and comes after `last_stamp_ns`.
[[nodiscard]] StereoFrame choose_frame(Choices& choices, const Rig& rig, std::int64_t last_stamp_ns);

[[nodiscard]] Pose2 choose_pose(Choices& choices);

/// Throws Finding where a number is not what its name promises: no probability, not finite, …
void check_result(const FrameResult& result);

}  // namespace stereogrid::fuzz
