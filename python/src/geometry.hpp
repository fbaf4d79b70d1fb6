// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::python {

/// Rig, and what else of a recording's calibration a pipeline is constructed with.
struct MountedRig {
  Rig rig;
  bool extrinsics_given{true};
  Image<std::uint8_t> mask{};
  std::string name{};  ///< name of one of several cameras (PipelineOptions::camera_names); empty: a numbered one
};

/// A rig, or those of several cameras.
using RigOrRigs = std::variant<MountedRig, std::vector<MountedRig>>;

/// The rigs, one at least. Throws ConfigError: none.
[[nodiscard]] std::vector<MountedRig> rigs_of(const RigOrRigs& one_or_more);
/// Names of several cameras; empty: one camera, or none has a name.
[[nodiscard]] std::vector<std::string> names_of(const std::vector<MountedRig>& rigs);
[[nodiscard]] std::vector<Rig> without_masks(const std::vector<MountedRig>& rigs);

/// Pose of the vehicle from Pose, three numbers (x_m, y_m, yaw_rad), or a matrix world_from_camera of 3 × 4 or 4 × 4;
/// None: none. Throws TypeError, ValueError.
[[nodiscard]] std::optional<Pose2> pose_of(nanobind::handle object);

/// "Name(x_m=1, y_m=2)" of pairs of name and value.
template <class... Fields>
std::string repr_of(const char* name, const Fields&... fields) {
  std::string text{name};
  const char* separator{"("};
  ((text += separator + std::string{fields.first} + "=" +
            nanobind::cast<std::string>(nanobind::repr(nanobind::cast(fields.second))),
    separator = ", "),
   ...);
  return text + ")";
}

}  // namespace stereogrid::python
