// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

namespace stereogrid::python {

// Each adds its classes and functions to the module. A class comes before the functions that return it, so that the
// type stubs name it.
void bind_errors(nanobind::module_& module);
void bind_config(nanobind::module_& module);
void bind_geometry(nanobind::module_& module);
void bind_obstacles(nanobind::module_& module);
void bind_result(nanobind::module_& module);
void bind_frame(nanobind::module_& module);
void bind_recording(nanobind::module_& module);
void bind_pipeline(nanobind::module_& module);
void bind_pickling(nanobind::module_& module);
void bind_run(nanobind::module_& module);
void bind_run_writer(nanobind::module_& module);

}  // namespace stereogrid::python
