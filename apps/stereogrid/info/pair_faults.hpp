// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "input.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::app {

/// Is one of the images black, or without anything that could be matched?
[[nodiscard]] bool is_without_texture(const StereoFrame& frame);

/// Is the road found when the rig is turned by 180° about its optical axis?
[[nodiscard]] bool is_upside_down(const StereoFrame& frame, const Config& config, const Rig& rig);

/// Why a pair that is not swapped hardly matches, and what would mend it: images of different instants, rows that are
/// off, images rectified twice. `index`: the frame's place in `input`.
[[nodiscard]] std::string fault_of_pair(const Input& input, std::size_t index, const StereoFrame& frame);

}  // namespace stereogrid::app
