// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Started with an emulated libstereogrid_cuda.so that finds no GPU. What that library throws crosses the core's.
#include <stereogrid/error.hpp>
#include <stereogrid/pipeline.hpp>

#include <cstdio>
#include <string>

int main() {
  stereogrid::Rig rig;
  rig.width_px = 200;
  rig.height_px = 120;
  rig.focal_px = 160;
  rig.cx_px = 100;
  rig.cy_px = 60;
  rig.baseline_m = 0.5;
  try {
    const stereogrid::Pipeline pipeline{stereogrid::preset("default"), rig, {.back_end = stereogrid::BackEnd::cuda}};
  } catch (const stereogrid::DeviceError& error) {
    std::printf("%s\n", error.what());
    return std::string{error.what()}.find("No NVIDIA GPU was found") != std::string::npos ? 0 : 1;
  }
  return 1;
}
