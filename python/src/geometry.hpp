// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <string>
#include <utility>

#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::python {

/// Rig, and what else of a recording's calibration a pipeline is constructed with.
struct MountedRig {
  Rig rig;
  bool extrinsics_given{true};
  Image<std::uint8_t> mask{};
};

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
