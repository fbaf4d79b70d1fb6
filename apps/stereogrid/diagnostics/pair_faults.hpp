// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "input.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::app {

/// True if one of the images is black or without texture.
[[nodiscard]] bool is_without_texture(const StereoFrame& frame);

/// True if the road is found when the rig is rotated by 180° about its optical axis.
[[nodiscard]] bool is_upside_down(const StereoFrame& frame, const Config& config, const Rig& rig);

/// Reason for the few matches of a pair, and its remedy.
struct PairFault {
  std::string text;
  bool is_swapped{false};
};

/// Finds the fault of a pair that hardly matches: no texture, sides swapped, images of different instants, vertical
/// misalignment, images rectified twice. The text is empty if none of them is found. `index`: place of the frame in
/// `input`, which may lack a source; then its neighbours are not compared.
[[nodiscard]] PairFault fault_of_pair(const Input& input, std::size_t index, const StereoFrame& frame);

}  // namespace stereogrid::app
