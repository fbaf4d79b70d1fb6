// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "backend/reference.hpp"
#include "check.hpp"
#include "images.hpp"
#include "matching/checks/external.hpp"
#include "matching/cuda.hpp"
#include "matching/matching.hpp"

namespace stereogrid::test {

struct Size {
  int width;
  int height;
};

struct Pair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

inline int uniform(std::mt19937& generator, int count) {
  return static_cast<int>(generator() % static_cast<unsigned>(count));
}

inline Image<std::uint8_t> noise_image(Size size, std::mt19937& generator) {
  Image<std::uint8_t> image{size.width, size.height};
  for (auto& grey : image) grey = static_cast<std::uint8_t>(uniform(generator, 256));
  return image;
}

inline Pair noise_pair(Size size, unsigned seed) {
  std::mt19937 generator{seed};
  Image<std::uint8_t> left{noise_image(size, generator)};
  return {left, noise_image(size, generator)};
}

/// Two disparities side by side, some noise, and a flat patch where many costs tie.
inline Pair textured_pair(Size size, unsigned seed) {
  std::mt19937 generator{seed};
  const Image<std::uint8_t> texture{noise_image({size.width + 8, size.height}, generator)};
  Pair pair{Image<std::uint8_t>{size.width, size.height}, Image<std::uint8_t>{size.width, size.height}};
  for (int v{0}; v < size.height; ++v) {
    for (int u{0}; u < size.width; ++u) {
      const bool is_flat{v >= size.height / 2 && u < size.width / 3};
      const int noise{uniform(generator, 12)};
      pair.left(u, v) = is_flat ? std::uint8_t{90} : texture(u, v);
      const int grey{texture(u + (u < size.width / 2 ? 3 : 8), v) / 2 + noise};
      pair.right(u, v) = is_flat ? std::uint8_t{90} : static_cast<std::uint8_t>(grey);
    }
  }
  return pair;
}

/// Noise, and a strip of four rows that is found at one disparity.
inline Pair topped_pair(Size size, int first_v, int disparity, unsigned seed) {
  Pair pair{noise_pair(size, seed)};
  for (int v{first_v}; v < first_v + 4; ++v) {
    for (int u{0}; u + disparity < size.width; ++u) pair.right(u, v) = pair.left(u + disparity, v);
  }
  return pair;
}

/// Noise in which a pixel of the left image is found at either of two disparities.
inline Pair doubled_pair(Size size, int one, int other, unsigned seed) {
  std::mt19937 generator{seed};
  Pair pair{noise_image(size, generator), Image<std::uint8_t>{size.width, size.height}};
  for (int v{0}; v < size.height; ++v) {
    for (int u{0}; u < size.width; ++u) {
      const int shift{uniform(generator, 2) == 0 ? one : other};
      pair.right(u, v) = pair.left(std::min(u + shift, size.width - 1), v);
    }
  }
  return pair;
}

/// Result of the reference.
class ReferenceRun final : public CandidateSink {
 public:
  ReferenceRun(const Pair& pair, const RoadPlane& plane, const MatchingConfig& config)
      : matches{pair.left.width(), pair.left.height()},
        upright{pair.left.width(), pair.left.height()},
        level{pair.left.width(), pair.left.height()} {
    Reference reference;
    MatchingWorkspace space{pair.left.width(), pair.left.height(), config, 1};
    find_candidates(reference, pair.left.view(), pair.right.view(), plane, config, space, *this);
    match(reference, pair.left.view(), pair.right.view(), plane, config, space, matches);
  }

  void take(int v, RowCandidates& candidates) override {
    for (int u{0}; u < upright.width(); ++u) {
      upright(u, v) = candidates.upright.at(u);
      level(u, v) = candidates.level.at(u);
    }
  }

  Matches matches;
  Image<Candidate> upright;
  Image<Candidate> level;
};

inline int differences(const Image<Candidate>& expected, const Image<FoundLabel>& found, Shifts shifts) {
  int different{0};
  for (std::size_t i{0}; i < expected.size(); ++i) {
    const Candidate& a{expected.data()[i]};
    const FoundLabel& b{found.data()[i]};
    const bool same{a.cost == b.cost && a.before == b.before && a.after == b.after &&
                    a.shift == shifts.first + b.label && a.has_rivals == b.has_rivals};
    different += same ? 0 : 1;
  }
  return different;
}

inline void check_same(const Matches& expected, Cuda& cuda, const DeviceMatches& found) {
  const Image<float> obstacle{on_host(cuda, found.obstacle)};
  CHECK_EQUAL(differences(expected.obstacle, obstacle), 0);
  CHECK(std::equal(expected.obstacle.begin(), expected.obstacle.end(), obstacle.begin(),
                   [](float a, float b) { return is_ambiguous(a) == is_ambiguous(b); }));
  CHECK_EQUAL(differences(expected.road, on_host(cuda, found.road)), 0);
  CHECK_EQUAL(differences(expected.confidence, on_host(cuda, found.confidence)), 0);
}

class DeviceRun {
 public:
  DeviceRun(Size size, const MatchingConfig& config)
      : config_{config},
        left_{size.width, size.height},
        right_{size.width, size.height},
        plane_{1},
        space_{size.width, size.height, config},
        matches_{size.width, size.height} {}

  Cuda& cuda() { return cuda_; }

  void put(const Pair& pair, const RoadPlane& plane) {
    upload(cuda_, pair.left.data(), pair.left.size(), left_.data());
    upload(cuda_, pair.right.data(), pair.right.size(), right_.data());
    upload(cuda_, &plane, 1, plane_.data());
    cuda_.synchronize();
  }

  void match_all() { match(cuda_, left_.view(), right_.view(), plane_.data(), config_, space_, matches_); }

  void check_candidates(const ReferenceRun& expected) {
    CHECK_EQUAL(differences(expected.upright, on_host(cuda_, space_.upright), upright_shifts(config_)), 0);
    CHECK_EQUAL(differences(expected.level, on_host(cuda_, space_.level), road_shifts), 0);
  }

  void check_matches(const ReferenceRun& expected) { check_same(expected.matches, cuda_, matches_); }

 private:
  Cuda cuda_;
  MatchingConfig config_;
  DeviceImage<std::uint8_t> left_;
  DeviceImage<std::uint8_t> right_;
  DeviceBuffer<RoadPlane> plane_;
  MatchingWorkspaceOnDevice space_;
  DeviceMatches matches_;
};

inline void check_equal(const Pair& pair, const RoadPlane& plane, const MatchingConfig& config) {
  const int failures_before{failures};
  DeviceRun run{{pair.left.width(), pair.left.height()}, config};
  run.put(pair, plane);
  run.match_all();
  const ReferenceRun expected{pair, plane, config};
  run.check_candidates(expected);
  run.check_matches(expected);
  if (failures == failures_before) return;
  std::printf("  … of %d × %d, window %d, disparities %d\n", pair.left.width(), pair.left.height(), config.window_px,
              config.disparities);
}

/// Random obstacles and road, of disparities that often continue their neighbours'.
inline void check_speckles(Size size, int blank_percent, int speckle_px) {
  std::mt19937 generator{static_cast<unsigned>(blank_percent + speckle_px)};
  Matches expected{size.width, size.height};
  for (std::size_t i{0}; i < expected.road.size(); ++i) {
    if (uniform(generator, 100) < blank_percent) continue;
    const float disparity{8.0f + 0.25f * static_cast<float>(uniform(generator, 6))};
    (uniform(generator, 6) == 0 ? expected.road : expected.obstacle).data()[i] = disparity;
    expected.confidence.data()[i] = 0.5f;
  }
  Cuda cuda;
  DeviceMatches found{size.width, size.height};
  found.obstacle = on_device(cuda, expected.obstacle);
  found.road = on_device(cuda, expected.road);
  found.confidence = on_device(cuda, expected.confidence);
  DeviceImage<int> parents{size.width, size.height};
  DeviceImage<int> sizes{size.width, size.height};
  const SpeckleSizes smallest{speckle_px, 2 * speckle_px};
  remove_speckles(cuda, smallest, parents.view(), sizes.view(), found);
  Speckles{size.width, size.height}.remove(smallest, expected);
  check_same(expected, cuda, found);
}

inline void check_given(const Rig& rig, const Ground& ground) {
  std::mt19937 generator{137};
  MatchingConfig config;
  config.disparities = 32;
  Image<float> disparity{rig.width_px, rig.height_px};
  const RoadPlane plane{road_plane(rig, ground)};
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
      const double off{0.05 * (uniform(generator, 100) - 50)};
      disparity(u, v) = static_cast<float>(uniform(generator, 5) == 0 ? 0.0 : plane.disparity(u, v) + off);
    }
  }
  Cuda cuda;
  const DeviceImage<float> given{on_device(cuda, disparity)};
  const DeviceBuffer<Ground> ground_on_device{one_on_device(cuda, ground)};
  Matches expected{rig.width_px, rig.height_px};
  DeviceMatches found{rig.width_px, rig.height_px};
  found.confidence = on_device(cuda, expected.confidence);
  Reference reference;
  split(reference, disparity.view(), rig, ground, config, expected);
  split(cuda, given.view(), rig, ground_on_device.data(), config, found);
  check_same(expected, cuda, found);
  Image<std::int16_t> rows{2 * config.disparities, relief_sectors(rig.width_px)};
  for (std::int16_t& raised : rows) raised = static_cast<std::int16_t>(uniform(generator, 9) - 4);
  const DeviceImage<std::int16_t> rows_on_device{on_device(cuda, rows)};
  const Relief<Device> relief{rows_on_device.view()};
  Image<float> heights{rig.width_px, rig.height_px};
  split_surfaces(reference, disparity.view(), rig, ground, {std::as_const(rows).view()}, config, heights, expected);
  split_surfaces(cuda, given.view(), rig, ground_on_device.data(), relief, config, found);
  check_same(expected, cuda, found);
}

}  // namespace stereogrid::test
