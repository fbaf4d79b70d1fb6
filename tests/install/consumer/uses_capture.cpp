// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// A pipeline of GStreamer that does not exist is refused, one that does gives a frame.
#include <stereogrid/capture/gstreamer.hpp>
#include <stereogrid/error.hpp>

#include <chrono>
#include <cstdio>

using namespace stereogrid;

int main() {
  io::Calibration calibration;
  calibration.rig = {.width_px = 32, .height_px = 16, .focal_px = 30, .cx_px = 16, .cy_px = 8, .baseline_m = 1};
  try {
    static_cast<void>(capture::open_gstreamer("nosuchelement", calibration));
    return 1;
  } catch (const ConfigError& error) {  // across the library's border
    std::printf("%s\n", error.what());
  }
  const auto source{capture::open_gstreamer("videotestsrc ! video/x-raw,width=64,height=16", calibration)};
  for (int i{0}; i < 100; ++i) {
    if (source->next(std::chrono::milliseconds{100})) return 0;
  }
  std::printf("no frame: %s\n", source->fault().c_str());
  return 1;
}
