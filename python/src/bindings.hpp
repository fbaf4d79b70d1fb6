// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

namespace stereogrid::python {

/// Releases the GIL for work in C++. When the interpreter ends, other threads' sections are awaited, and a thread that
/// begins one then stops for good: CPython would end a daemon thread that requests the GIL by unwinding its stack,
/// which C++ answers with std::terminate.
class ReleasedGil {
 public:
  ReleasedGil();
  ReleasedGil(const ReleasedGil&) = delete;
  ReleasedGil& operator=(const ReleasedGil&) = delete;
  ~ReleasedGil();

 private:
  PyThreadState* state_;
};

/// Within a section: throws python_error where a signal's handler does, such as that of Ctrl-C.
void check_signals();

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
/// Adds the end of the interpreter to Python's atexit.
void bind_exit();

}  // namespace stereogrid::python
