// SPDX-License-Identifier: Apache-2.0
//
// Plugin of a host program without stereogrid; with HOST that program.
#ifdef HOST

#include <dlfcn.h>

#include <cstdio>

int main(int, char** arguments) {
  void* const plugin{dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL)};
  void* const function{plugin == nullptr ? nullptr : dlsym(plugin, "plugin_works")};
  if (function == nullptr) {
    std::printf("%s\n", dlerror());
    return 1;
  }
  return reinterpret_cast<int (*)()>(function)() == 1 ? 0 : 1;
}

#else

#include <stereogrid/error.hpp>
#include <stereogrid/pipeline.hpp>

/// Returns 1 if a pipeline can be created and its exceptions are caught here.
extern "C" __attribute__((visibility("default"))) int plugin_works() {
  const stereogrid::Config config{stereogrid::preset("default")};
  stereogrid::Rig rig{.width_px = 200, .height_px = 120, .focal_px = 160, .cx_px = 100, .cy_px = 60, .baseline_m = 0.5};
  const stereogrid::Pipeline pipeline{config, rig, {.threads = 1}};
  try {
    const stereogrid::Pipeline refused{config, stereogrid::Rig{}};
  } catch (const stereogrid::ConfigError&) {
    return pipeline.threads() == 1 ? 1 : 0;
  }
  return 0;
}

#endif
