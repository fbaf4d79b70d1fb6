// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <fstream>
#include <string>

#include "stereogrid/pipeline.hpp"

namespace stereogrid {

/// Prints processor and instruction set, without which times mean little. /proc/cpuinfo of ARM has no name.
inline void print_machine() {
  std::ifstream file{"/proc/cpuinfo"};
  std::string processor{"unknown processor"};
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) processor = line.substr(line.find(':') + 2);
  }
  std::printf("%s, %s\n\n", processor.c_str(), simd_target().data());
}

}  // namespace stereogrid
