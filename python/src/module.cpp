// SPDX-License-Identifier: Apache-2.0
#include <nanobind/stl/string_view.h>

#include "bindings.hpp"
#include "stereogrid/pipeline.hpp"

NB_MODULE(_core, module) {
  using namespace stereogrid::python;
  module.doc() = "Bindings of the C++ library; import stereogrid instead.";
  bind_exit();
  bind_errors(module);
  bind_config(module);
  bind_geometry(module);
  bind_obstacles(module);
  bind_result(module);
  bind_frame(module);
  bind_recording(module);
  bind_pipeline(module);
  bind_pickling(module);
  bind_run(module);
  bind_run_writer(module);
  module.def("version", &stereogrid::version, "Returns the version of the library, \"major.minor.patch\".");
  module.def("simd_target", &stereogrid::simd_target,
             "Returns the instruction set that the CPU back end uses on this machine.");
}
