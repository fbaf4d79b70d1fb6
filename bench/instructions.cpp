// SPDX-License-Identifier: Apache-2.0
//
// Frames for instructions.py to count the instructions of: the built-in scene of the paper's size in the default
// preset, on one thread; the argument is the side of the grid, 20 m. Prints the instruction set and the compiler.
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

constexpr std::size_t frames{6};

#ifdef __clang__
constexpr const char* compiler{"clang++ " __clang_version__};
#else
constexpr const char* compiler{"g++ " __VERSION__};
#endif

}  // namespace

int main(int argc, char** argv) {
  using namespace stereogrid;
  const scenes::Scene scene{scenes::parse_scene("street?width=512&height=320&focal=410")};
  Config config{preset("default")};
  config.grid.length_m = config.grid.width_m = argc > 1 ? std::atof(argv[1]) : 20;
  Pipeline pipeline{config, scene.rig(), {.threads = 1, .stages = false}};
  for (std::size_t i{0}; i < frames; ++i) static_cast<void>(pipeline.process(scene.load(i)));
  std::printf("%s, %s, %zu frames\n", simd_target().data(), compiler, frames);
}
