// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "matching/matching.hpp"

namespace stereogrid::test {

/// Every test of a match that can be switched off is off; left-right stays on.
inline MatchingConfig permissive_config() {
  MatchingConfig config;
  config.method = MatchingMethod::correlation;
  config.disparities = 32;
  config.window_px = 9;
  config.uniqueness = 0;
  config.texture = 0;
  config.cost_limit = 1;
  config.left_right_px = 1;
  config.speckle_px = config.road_speckle_px = 0;
  config.subpixel = true;
  return config;
}

/// No road anywhere in the image.
constexpr RoadPlane no_road{-1000, 0, 0, 0, 0};

/// Keeps what the hypotheses found.
class Recorder final : public CandidateSink {
 public:
  Recorder(Image<Candidate>& upright, Image<Candidate>& level) : upright_{upright}, level_{level} {}

  void take(int v, RowCandidates& candidates) override {
    for (int u{0}; u < upright_.width(); ++u) {
      upright_(u, v) = candidates.upright.at(u);
      level_(u, v) = candidates.level.at(u);
    }
  }

 private:
  Image<Candidate>& upright_;
  Image<Candidate>& level_;
};

inline int threads_of(const Cpu& cpu) {
  return cpu.threads();
}
inline int threads_of(const Reference&) {
  return 1;
}

struct MatchRun {
  template <class BackEndType>
  MatchRun(BackEndType& back_end, const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
           const RoadPlane& plane, const MatchingConfig& config)
      : space{left.width(), left.height(), config, threads_of(back_end)},
        matches{left.width(), left.height()},
        upright{left.width(), left.height()},
        level{left.width(), left.height()} {
    run(back_end, left, right, plane, config);
  }

  template <class BackEndType>
  void run(BackEndType& back_end, const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
           const RoadPlane& plane, const MatchingConfig& config) {
    matches.road.fill(-7);
    matches.obstacle.fill(-7);
    Recorder recorder{upright, level};
    find_candidates(back_end, left.view(), right.view(), plane, config, space, recorder);
    if (config.method == MatchingMethod::correlation) clear_unspecified(plane, config);
    match(back_end, left.view(), right.view(), plane, config, space, matches);
  }

  // Members that find_candidates need not set.
  void clear_unspecified(const RoadPlane& plane, const MatchingConfig& config) {
    for (int v{0}; v < upright.height(); ++v) {
      for (int u{0}; u < upright.width(); ++u) {
        Candidate& obstacle{upright(u, v)};
        Candidate& road{level(u, v)};
        const bool is_cheaper{road.cost < obstacle.cost};
        if (!is_cheaper) road = {road.cost, 0, 0, 0, 0};
        const bool is_road{is_cheaper && road_row(plane, v).at(u) > 65535};
        if (is_road || obstacle.cost > confidence_model(config).cost_limit) {
          obstacle = {obstacle.cost, 0, 0, 0, obstacle.shift};
        }
      }
    }
  }

  MatchingWorkspace space;
  Matches matches;
  Image<Candidate> upright;
  Image<Candidate> level;
};

}  // namespace stereogrid::test
