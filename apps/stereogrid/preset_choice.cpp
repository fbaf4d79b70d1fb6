// SPDX-License-Identifier: Apache-2.0
#include "preset_choice.hpp"

#include <fmt/format.h>

#include <cstddef>

#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

constexpr double low_m{0.6};  // cameras below it are robots'
constexpr int frames_tried{10};

}  // namespace

const char* const automatic_preset{"auto"};

PresetChoice choose_preset(const Rig& rig, bool has_extrinsics, const Image<std::uint8_t>& mask,
                           const std::function<std::optional<StereoFrame>()>& next) {
  const auto chosen = [](const Rig& found, const char* how) {
    const char* const name{found.camera_height_m < low_m ? "robot" : "default"};
    return PresetChoice{name, fmt::format("camera {:.2f} m above the ground ({})", found.camera_height_m, how), found};
  };
  if (has_extrinsics) return chosen(rig, "calibration");
  Pipeline pipeline{preset("default"), rig, {.stages = false, .mask = mask, .extrinsics_given = false}};
  for (int tried{0}; tried < frames_tried; ++tried) {
    const std::optional<StereoFrame> frame{next()};
    if (!frame) break;
    try {
      pipeline.process(*frame);
    } catch (const InputError&) {  // reported where the frame is used
    }
    if (pipeline.next_rig() != rig) return chosen(pipeline.next_rig(), "estimated");
  }
  return {"default", "height of the camera not found in the first frames: give mount.camera_height_m", rig};
}

PresetChoice choose_preset(const Input& input) {
  std::size_t index{0};
  return choose_preset(input.source->rig(), input.extrinsics_given, input.mask, [&]() -> std::optional<StereoFrame> {
    while (index < input.source->size()) {
      try {
        return input.source->load(index++);
      } catch (const InputError&) {  // reported where the frame is used
      }
    }
    return std::nullopt;
  });
}

std::string advice_on_preset(const Config& config, const Rig& rig) {
  constexpr double step_of_cars_m{0.1};
  const bool is_for_cars{config.ground.model == GroundModel::terrain && config.vehicle.step_max_m > step_of_cars_m};
  if (rig.camera_height_m >= low_m || !is_for_cars) return {};
  return fmt::format(
      "--preset robot is made for a camera {:.2f} m above the ground: small cells, steps of 3 cm, speeds of people. "
      "--preset auto selects it",
      rig.camera_height_m);
}

}  // namespace stereogrid::app
