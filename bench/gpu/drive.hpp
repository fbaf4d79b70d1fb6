// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "backend/cpu.hpp"
#include "chain.hpp"
#include "pipeline/cuda/stages.hpp"
#include "pipeline/frame_pipeline.hpp"
#include "pipeline/results.hpp"
#include "street.hpp"

namespace stereogrid::bench {

inline constexpr int drawn_frames{6};
inline constexpr int warm_up{10};
inline constexpr double frame_s{0.1};

inline Config config_of(const Case& what) {
  Config config{preset("default")};
  config.matching.disparities = what.disparities;
  return config;
}

/// Frames, shown forth and back.
inline std::vector<StereoFrame> drawn(const Case& what) {
  const test::Street street{test::Street::rig(what.width, what.height)};
  std::vector<StereoFrame> frames;
  for (int i{0}; i < drawn_frames; ++i) frames.push_back(street.frame(i));
  for (int i{drawn_frames - 2}; i > 0; --i) frames.push_back(frames[static_cast<std::size_t>(i)]);
  return frames;
}

/// A pipeline on the GPU, and how far it has come.
class Drive {
 public:
  explicit Drive(const Case& what)
      : rig_{test::Street::rig(what.width, what.height)},
        stages_{new CudaStages{config_of(what), rig_, 0, {.stage_images = false}}},
        pipeline_{config_of(what), rig_, cpu_, std::unique_ptr<Stages>{stages_}},
        result_{empty_result(config_of(what), rig_)} {}

  void step(const std::vector<StereoFrame>& frames) {
    const StereoFrame& frame{frames[static_cast<std::size_t>(done_) % frames.size()]};
    const LevelFrame level{
        frame.left.view(), frame.right.view(), {}, *frame.world_from_vehicle, done_ == 0 ? 0 : frame_s};
    pipeline_.process({{&level, 1}, level.world_from_camera, level.dt_s}, result_);
    ++done_;
  }

  [[nodiscard]] CudaStages& stages() { return *stages_; }
  [[nodiscard]] const StreamTimes& times() const { return stages_->times(); }

 private:
  Rig rig_;
  Cpu cpu_{1};
  CudaStages* stages_;  ///< owned by the pipeline
  FramePipeline pipeline_;
  FrameResult result_;
  int done_{0};
};

}  // namespace stereogrid::bench
