// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run_description.hpp"

#include <string>

#include "device_options.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::app {

io::RunDescription describe_run(const Input& input, const InputOptions& options, const Pipeline& pipeline,
                                io::FrameRange frames) {
  const bool given{input.recording != nullptr && input.recording->gives_disparities()};
  io::RunDescription run;
  run.config = pipeline.config();
  run.input = describe(input, options);
  run.matcher = given ? "given" : "own";
  run.device = std::string{name_of(pipeline.back_end())};
  run.rig = pipeline.rig();
  run.grid = pipeline.vehicle_grid();
  run.world_grid = pipeline.world_grid();
  run.simd_target = std::string{simd_target()};
  run.threads = pipeline.threads();
  run.frames = frames;
  return run;
}

}  // namespace stereogrid::app
