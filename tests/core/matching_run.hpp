// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "matching/matching.hpp"
#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {

/// Every test of a match that can be switched off is off; left-right stays on.
inline MatchingConfig permissive_config() {
  MatchingConfig config;
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
    clear_unspecified(plane, config);
    match(back_end, left.view(), right.view(), plane, config, space, matches);
  }

  // Members that find_candidates need not set.
  void clear_unspecified(const RoadPlane& plane, const MatchingConfig& config) {
    for (const auto [u, v] : raster(upright)) {
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

  MatchingWorkspace space;
  Matches matches;
  Image<Candidate> upright;
  Image<Candidate> level;
};

struct Size {
  int width;
  int height;
};

struct Pair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

inline Pair noise_pair(Size size, std::mt19937& generator) {
  return {noise_image(size.width, size.height, generator), noise_image(size.width, size.height, generator)};
}

/// Texture with a step in disparity, and a flat patch where many costs tie.
inline Pair textured_pair(Size size, std::mt19937& generator) {
  const Texture texture{static_cast<unsigned>(generator())};
  const auto shift = [&](int u) { return u < size.width / 2 ? 3 : 8; };
  Pair pair{textured_image(texture, size.width, size.height, [](int u, int) { return u; }),
            textured_image(texture, size.width, size.height, [&](int u, int) { return u + shift(u); })};
  for (const auto [u, v] : raster(0, size.width / 3, size.height / 2, size.height))
    pair.left(u, v) = pair.right(u, v) = 90;
  return pair;
}

/// Settings where every test of a match rejects some.
inline MatchingConfig config_of(int window_px, int disparities) {
  MatchingConfig config{permissive_config()};
  config.window_px = window_px;
  config.disparities = disparities;
  config.texture = 3;
  config.uniqueness = 0.05;
  config.speckle_px = config.road_speckle_px = 4;
  return config;
}

constexpr RoadPlane plain_plane{4, 0, 0.2, 20, 15};
constexpr RoadPlane rolled_plane{3.3, 0.07, 0.31, 30, 10};
constexpr RoadPlane falling_plane{-2, -0.11, 0.15, 10, 5};  // mostly behind the camera: negative disparities

inline int differences(const Image<Candidate>& a, const Image<Candidate>& b) {
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += a.data()[i] == b.data()[i] ? 0 : 1;
  return different;
}

inline void expect_equal(const MatchRun& expected, const MatchRun& actual) {
  EXPECT_EQ(differences(expected.upright, actual.upright), 0);
  EXPECT_EQ(differences(expected.level, actual.level), 0);
  EXPECT_EQ(count_differences(expected.matches.obstacle, actual.matches.obstacle), 0);
  for (std::size_t i{0}; i < expected.matches.obstacle.size(); ++i) {
    ASSERT_EQ(is_ambiguous(expected.matches.obstacle.data()[i]), is_ambiguous(actual.matches.obstacle.data()[i])) << i;
  }
  EXPECT_EQ(count_differences(expected.matches.road, actual.matches.road), 0);
  EXPECT_EQ(count_differences(expected.matches.confidence, actual.matches.confidence), 0);
}

/// The CPU's results are the reference's, on every instruction set of this machine and on each of these numbers of
/// threads.
inline void expect_equal_to_reference(const Pair& pair, const RoadPlane& plane, const MatchingConfig& config,
                                      const std::vector<int>& thread_counts) {
  Reference reference;
  const MatchRun expected{reference, pair.left, pair.right, plane, config};
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    ASSERT_EQ(simd_target(), name_of_target(target));
    for (const int threads : thread_counts) {
      SCOPED_TRACE(testing::Message() << pair.left.width() << " × " << pair.left.height() << ", window "
                                      << config.window_px << ", disparities " << config.disparities << ", "
                                      << simd_target() << ", " << threads << " threads");
      Cpu cpu{threads};
      expect_equal(expected, MatchRun{cpu, pair.left, pair.right, plane, config});
    }
  }
}

}  // namespace stereogrid::test
