// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"

namespace stereogrid {
namespace {

constexpr int threads{256};
constexpr int places_max{8192};  // columns of the right image whose claims are kept at once

struct Decision {
  View<const FoundLabel, Device> upright;
  View<const FoundLabel, Device> level;
  View<const std::uint8_t, Device> textured;  // without data: there is always enough
  const RoadPlane* plane;
  int road_first;
  int disparities;
  int left_right_px;
  bool subpixel;
  ConfidenceModel confidences;
  View<float, Device> obstacle;
  View<float, Device> road;
  View<float, Device> confidence;
};

__device__ Candidate candidate_of(const FoundLabel& found, int first) {
  return {found.cost, found.has_rivals, found.before, found.after, static_cast<std::int16_t>(first + found.label)};
}

__device__ Winner winner_at(const Decision& task, const RoadRow& road, int u, int v) {
  return winner_of(candidate_of(task.upright(u, v), 0), candidate_of(task.level(u, v), task.road_first), road.at(u),
                   task.disparities, task.subpixel, task.confidences);
}

__device__ bool is_textured(const Decision& task, int u, int v) {
  return task.textured.data == nullptr || task.textured(u, v) != 0;
}

__device__ float unmatched(const Decision& task, const Winner& winner, int u, int v) {
  const bool is_similar{winner.cost <= task.confidences.ambiguous_cost_limit};
  return is_similar && !winner.is_road && winner.whole > 0 && is_textured(task, u, v) ? ambiguous_px : 0.0f;
}

__device__ void accept(const Decision& task, const Winner& winner, int claimed_whole, int u, int v) {
  const int off{claimed_whole - winner.whole};
  const bool consistent{(off < 0 ? -off : off) <= task.left_right_px};
  const bool accepted{consistent && winner.is_plausible && is_textured(task, u, v)};
  task.road(u, v) = accepted && winner.is_road ? winner.disparity : 0.0f;
  task.obstacle(u, v) = accepted && !winner.is_road ? winner.disparity : unmatched(task, winner, u, v);
  task.confidence(u, v) = accepted ? single_numbers::confidence_of(winner.evidence) : 0.0f;
}

// A block decides a row. A claim is cost · 65536 + whole: the cheapest wins, then the smaller disparity.
__global__ void __launch_bounds__(threads) decide_rows(Decision task) {
  auto* const claims = dynamic_shared<unsigned>();
  const int width{task.upright.width};
  const int v{static_cast<int>(blockIdx.x)};
  const int thread{static_cast<int>(threadIdx.x)};
  const RoadRow road{road_row(*task.plane, v)};
  for (int first{0}; first < width; first += places_max) {
    const int places{min(places_max, width - first)};
    for (int place{thread}; place < places; place += threads) claims[place] = ~0u;
    __syncthreads();
    for (int u{thread}; u < width; u += threads) {
      const Winner winner{winner_at(task, road, u, v)};
      const int place{u - winner.whole - first};
      if (place < 0 || place >= places) continue;
      atomicMin(claims + place, static_cast<unsigned>(winner.cost) << 16 | static_cast<std::uint16_t>(winner.whole));
    }
    __syncthreads();
    for (int u{thread}; u < width; u += threads) {
      const Winner winner{winner_at(task, road, u, v)};
      const int place{u - winner.whole - first};
      if (place >= 0 && place < places) {
        accept(task, winner, static_cast<std::int16_t>(claims[place] & 0xffffu), u, v);
      } else if (first == 0 && (u < winner.whole || u - winner.whole >= width)) {
        task.road(u, v) = task.confidence(u, v) = 0.0f;
        task.obstacle(u, v) = unmatched(task, winner, u, v);
      }
    }
    __syncthreads();
  }
}

}  // namespace

void decide(Cuda& cuda, View<const FoundLabel, Device> upright, View<const FoundLabel, Device> level,
            View<const std::uint8_t, Device> textured, const RoadPlane* plane, const MatchingConfig& config,
            DeviceMatches& matches) {
  if (least_texture(config) <= 0) textured.data = nullptr;
  const Decision task{upright,
                      level,
                      textured,
                      plane,
                      road_shifts.first,
                      config.disparities,
                      config.left_right_px,
                      config.subpixel,
                      confidence_model(config),
                      matches.obstacle.view(),
                      matches.road.view(),
                      matches.confidence.view()};
  const int places{upright.width < places_max ? upright.width : places_max};
  launch(cuda, decide_rows, dim3{static_cast<unsigned>(upright.height)}, dim3{threads},
         static_cast<std::size_t>(places) * sizeof(unsigned), task);
}

}  // namespace stereogrid
