// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "chain.hpp"
#include "pipeline/cuda/stages.hpp"
#include "pipeline/frame_processor.hpp"
#include "pipeline/results.hpp"
#include "street.hpp"

namespace stereogrid::bench {

inline constexpr int drawn_frames{6};
inline constexpr int warm_up{10};
inline constexpr double frame_s{0.1};

inline Config config_of(const Case& what) {
  Config config{preset("default")};
  config.matching.method = what.method;
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
        stages_{new CudaStages{config_of(what), rig_}},
        processor_{config_of(what), rig_, std::unique_ptr<Stages>{stages_}},
        results_{empty_result(config_of(what), rig_), empty_result(config_of(what), rig_)} {
    stages_->fetch_stages(false);
  }

  void step(const std::vector<StereoFrame>& frames) { go(frames, 1); }

  /// The device begins each frame but the first while the host is still busy with the one before.
  void go(const std::vector<StereoFrame>& frames, int count) {
    start(frames);
    for (int i{0}; i < count; ++i) {
      const LevelFrame frame{started_};
      FrameResult& result{results_[static_cast<std::size_t>(done_ % 2)]};
      ++done_;
      processor_.finish(frame, result, {{}, [&] {
                                          if (i + 1 < count) start(frames);
                                        }});
    }
  }

  [[nodiscard]] CudaStages& stages() { return *stages_; }
  [[nodiscard]] const StreamTimes& times() const { return stages_->times(); }

 private:
  void start(const std::vector<StereoFrame>& frames) {
    const StereoFrame& frame{frames[static_cast<std::size_t>(done_) % frames.size()]};
    started_ = {frame.left.view(), frame.right.view(), {}, *frame.world_from_vehicle, done_ == 0 ? 0 : frame_s, {}};
    processor_.start(started_, results_[static_cast<std::size_t>(done_ % 2)]);
  }

  Rig rig_;
  CudaStages* stages_;  ///< of the processor
  FrameProcessor processor_;
  FrameResult results_[2];
  LevelFrame started_;
  int done_{0};
};

}  // namespace stereogrid::bench
