// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The frame pipeline's state between two frames: reset, saved, measured.
#include "pipeline/frame_pipeline.hpp"

namespace stereogrid {

// The other members are working memory, or reset by the first frame.
void FramePipeline::reset() {
  ground_ = calibrated_ground(rig_, config_.ground);
  frames_to_search_ = 0;
  is_first_ = true;
  has_measured_ground_ = false;
  alignment_ = RowAlignment{rig_};
  validator_ = FrameValidator{rig_, config_.ground, config_.matching.disparities};
  extrinsics_search_.begin_again();
  scene_flow_ = SceneFlow{rig_};
  tracker_.forget();
  near_.clear();
  if (terrain_) terrain_->reset();
}

template <class State>
void FramePipeline::exchange(State& state) {
  state(ground_, frames_to_search_, is_first_, has_measured_ground_, alignment_, validator_, extrinsics_search_,
        scene_flow_, tracker_, near_);
  if (terrain_) state(*terrain_);
}

void FramePipeline::save(StateWriter& state) {
  exchange(state);
  stages_->save(state);
}

void FramePipeline::load(StateReader& state) {
  exchange(state);
  stages_->load(state);
}

MemoryUse FramePipeline::memory_use() const {
  MemoryUse use{stages_->memory_use()};
  if (terrain_) use.host_bytes += held_bytes_of(*terrain_);
  use.host_bytes += sizeof *this + held_bytes_of(mask_, validator_, alignment_, scene_flow_, tracker_, near_,
                                                 ground_samples_, extrinsics_samples_, velocity_evidence_, clusters_);
  return use;
}

}  // namespace stereogrid
