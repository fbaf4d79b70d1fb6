// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>

#include "support.hpp"
#include "targets/pipeline_input.hpp"

namespace stereogrid::fuzz {
namespace {

PipelineOptions choose_options(Choices& choices, BackEnd back_end) {
  PipelineOptions options{.back_end = back_end, .threads = 1, .stages = choices.yes()};
  if (choices.once_in(4)) {
    for (int count{choices.between(0, 3)}; count > 0; --count) {
      options.horizons_s.push_back(choices.once_in(4) ? choices.any_number() : choices.number(0.1, 3));
    }
  }
  if (choices.once_in(8)) options.start = choose_pose(choices);
  return options;
}

void drive(Choices& choices, Pipeline& pipeline) {
  if (choices.once_in(8) && choices.between(0, 1000) > 500) pipeline.reset();
  FrameResult kept;
  std::int64_t stamp_ns{choices.once_in(8) ? choices.any_integer() : 0};
  for (int frames{choices.between(1, 5)}; frames > 0; --frames) {
    const StereoFrame frame{choose_frame(choices, pipeline.rig(), stamp_ns)};
    const bool used{accepts([&] {
      if (!choices.once_in(4)) return check_result(pipeline.process(frame));
      pipeline.process(frame, kept);
      check_result(kept);
    })};
    if (used) stamp_ns = frame.stamp_ns;
  }
}

}  // namespace

/// Decisions.
FUZZ_TARGET(pipeline) {
  Choices choices{input};
  const BackEnd back_end{choices.once_in(3) ? BackEnd::reference : BackEnd::cpu};
  Rig rig{choose_rig(choices)};
  if (back_end == BackEnd::reference) {  // it compares every pixel of every window
    rig.width_px = std::min(rig.width_px, 24);
    rig.height_px = std::min(rig.height_px, 16);
  }
  const Config config{choose_config(choices)};
  if (!is_small(config)) return;
  const PipelineOptions options{choose_options(choices, back_end)};
  std::optional<Pipeline> pipeline;
  if (!accepts([&] { pipeline.emplace(config, rig, options); })) return;
  drive(choices, *pipeline);
}

}  // namespace stereogrid::fuzz
