// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "input.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::app {

/// Name of --preset that stands for the preset of the camera's height.
extern const char* const automatic_preset;

/// Preset for the height of the left camera above the ground, with the reason as a text.
struct PresetChoice {
  std::string preset;  ///< "default" or "robot"
  std::string reason;
  Rig rig;  ///< with the estimated extrinsics, where the first frames show them
};

/// "robot" below 0.6 m, else "default"; also where the height is unknown. Without measured extrinsics, the height is
/// estimated from the first 10 usable frames, by a pipeline of its own. `next`: returns the next usable frame; none:
/// there are no more.
[[nodiscard]] PresetChoice choose_preset(const Rig& rig, bool has_extrinsics, const Image<std::uint8_t>& mask,
                                         const std::function<std::optional<StereoFrame>()>& next);
/// The same with the first frames of an input. Throws DeviceError where they cannot be read now.
[[nodiscard]] PresetChoice choose_preset(const Input& input);

/// Advice on the preset where choose_preset() returns another one than `config` is made for; "": none.
[[nodiscard]] std::string advice_on_preset(const Config& config, const Rig& rig);

}  // namespace stereogrid::app
