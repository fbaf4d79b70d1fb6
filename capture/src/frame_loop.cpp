// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/capture/frame_loop.hpp"

#include "stereogrid/error.hpp"

namespace stereogrid::capture {

FrameHandler::~FrameHandler() = default;

void run_frames(Pipeline& pipeline, FrameHandler& frames) {
  FrameResult result;
  while (!frames.has_ended()) {
    try {
      std::optional<PreparedFrame> prepared{frames.next()};
      if (!prepared) continue;
      if (prepared->resets_before) pipeline.reset();
      pipeline.process(prepared->frame, result);
      if (prepared->odometry_ms) result.timing_ms.odometry = *prepared->odometry_ms;
      if (prepared->warning) result.warnings.push_back({std::move(*prepared->warning)});
      frames.deliver(*prepared, result);
    } catch (const InputError& error) {
      frames.refuse(error.what());
    }
  }
}

}  // namespace stereogrid::capture
