// SPDX-License-Identifier: Apache-2.0
//
// The C++ side of python.py, a library for ctypes: a pipeline whose frames' pixels are in foreign memory.
#include <chrono>
#include <cstdint>

#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

struct Loop {
  explicit Loop(const stereogrid::Rig& rig) : pipeline{stereogrid::preset("default"), rig, {.threads = 1}} {}

  stereogrid::Pipeline pipeline;
  stereogrid::StereoFrame frame;
  stereogrid::FrameResult result;
};

double now_us() {
  return std::chrono::duration<double, std::micro>{std::chrono::steady_clock::now().time_since_epoch()}.count();
}

}  // namespace

extern "C" {

STEREOGRID_EXPORT void* make_loop(const char* scene) {
  return new Loop{stereogrid::scenes::Scene{stereogrid::scenes::parse_scene(scene)}.rig()};
}

STEREOGRID_EXPORT void delete_loop(void* loop) {
  delete static_cast<Loop*>(loop);
}

/// Time of a frame outside Pipeline::process()'s own clock, in µs: checks and call.
STEREOGRID_EXPORT double frame_us(void* loop, const std::uint8_t* left, const std::uint8_t* right, int width_px,
                                  int height_px, std::int64_t stamp_ns) {
  auto& [pipeline, frame, result]{*static_cast<Loop*>(loop)};
  const double begin_us{now_us()};
  frame.stamp_ns = stamp_ns;
  stereogrid::FrameImages images;
  images.left = {left, width_px, height_px, width_px};
  images.right = {right, width_px, height_px, width_px};
  pipeline.process(frame, images, result);
  return now_us() - begin_us - 1e3 * result.timing_ms.total;
}
}
