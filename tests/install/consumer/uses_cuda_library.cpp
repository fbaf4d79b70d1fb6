// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Started with an emulated libstereogrid_cuda.so that finds no GPU. What that library throws crosses the core's.
#include <stereogrid/error.hpp>
#include <stereogrid/pipeline.hpp>

#include <cstdio>
#include <string>

int main() {
  stereogrid::Rig rig{.width_px = 200, .height_px = 120, .focal_px = 160, .cx_px = 100, .cy_px = 60, .baseline_m = 0.5};
  try {
    const stereogrid::Pipeline pipeline{stereogrid::preset("default"), rig, {.back_end = stereogrid::BackEnd::cuda}};
  } catch (const stereogrid::DeviceError& error) {
    std::printf("%s\n", error.what());
    return std::string{error.what()}.find("No NVIDIA GPU was found") != std::string::npos ? 0 : 1;
  }
  return 1;
}
