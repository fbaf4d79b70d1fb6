// SPDX-License-Identifier: Apache-2.0
//
// Semi-global matching with a warp per path, whose lanes have the labels. All paths of all directions run at the same
// time and leave their costs in volumes of bytes; the last direction, upwards, adds them up as it goes and picks the
// best labels, so that sums are never stored.
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"
#include "matching/semi_global/paths.cuh"
#include "matching/semi_global/semi_global.hpp"

namespace stereogrid {
namespace {

struct Direction {
  int du;
  int dv;
};

constexpr Direction upwards{0, -1};

// As in the reference, but for the last one, upwards.
constexpr int volumes{2};

struct Problem {
  int width;
  int height;
  Shifts upright;
  Shifts road;
  LabelVolume volume;
  StepPenalties penalties;
  const std::int16_t* meeting;
  std::uint32_t* costs;
  std::uint32_t* paths[volumes];  // from the left, from the right
};

__global__ void find_meetings(View<std::int16_t, Device> meeting, const RoadPlane* plane, Shifts upright, Shifts road) {
  const int u{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  const int v{static_cast<int>(blockIdx.y)};
  if (u >= meeting.width) return;
  meeting(u, v) = row_has_road(*plane, meeting.width, v)
                      ? static_cast<std::int16_t>(meeting_label(*plane, upright, road, u, v))
                      : no_road;
}

constexpr int cost_threads{256};

// threadIdx.x: the word of a pixel's labels, threadIdx.y: the pixel.
__global__ void __launch_bounds__(cost_threads)
    find_costs(Problem problem, View<const std::uint32_t, Device> left, View<const std::uint32_t, Device> right,
               View<const std::uint32_t, Device> sheared_right) {
  const int u{static_cast<int>(blockIdx.x * blockDim.y + threadIdx.y)};
  const int v{static_cast<int>(blockIdx.y)};
  if (u >= problem.width) return;
  const int pixel{v * problem.width + u};
  const int word{static_cast<int>(threadIdx.x)};
  const bool is_road{word >= problem.volume.upright_words};
  const Shifts shifts{is_road ? problem.road : problem.upright};
  const std::uint32_t* const row{is_road ? sheared_right.row(v) : right.row(v)};
  const std::uint32_t descriptor{left(u, v)};
  const bool can_be{!is_road || problem.meeting[pixel] != no_road};
  const int first{4 * (is_road ? word - problem.volume.upright_words : word)};
  std::uint32_t costs{0};
  for (int k{0}; k < 4; ++k) {
    const int at{clamped(u - shifts.first - first - k, problem.width)};
    const int cost{can_be && first + k < shifts.count ? __popc(descriptor ^ __ldg(row + at)) : cost_max};
    costs |= static_cast<std::uint32_t>(cost) << (8 * k);
  }
  problem.costs[static_cast<std::size_t>(pixel) * static_cast<std::size_t>(problem.volume.words) +
                static_cast<std::size_t>(word)] = costs;
}

// One path, and where a lane finds its labels on it.
class Line {
 public:
  __device__ Line(const Problem& problem, Direction direction, int line)
      : problem_{problem}, lane_{static_cast<int>(threadIdx.x)} {
    const bool is_up{direction.dv < 0};
    const int u{is_up ? line : (direction.du < 0 ? problem.width - 1 : 0)};
    const int v{is_up ? problem.height - 1 : line};
    length_ = is_up ? problem.height : problem.width;
    first_ = v * problem.width + u;
    step_ = direction.dv * problem.width + direction.du;
  }

  [[nodiscard]] __device__ int length() const { return length_; }
  [[nodiscard]] __device__ int pixel(int i) const { return first_ + i * step_; }

  template <int words>
  __device__ PixelCosts<words> costs(int i) const {
    PixelCosts<words> costs;
    load(problem_.costs, i, costs.upright, costs.road);
    costs.meeting = __ldg(problem_.meeting + pixel(i));
    return costs;
  }

  template <int words>
  __device__ void load(const std::uint32_t* volume, int i, std::uint32_t (&upright)[words], std::uint32_t& road) const {
    const std::uint32_t* const labels{volume + place(i)};
    const LabelVolume& layout{problem_.volume};
    for (int k{0}; k < words; ++k) upright[k] = has_upright(k) ? labels[lane_ + 32 * k] : ~0u;
    road = has_road() ? labels[layout.upright_words + lane_] : ~0u;
  }

  template <int words>
  __device__ void store(std::uint32_t* volume, int i, const PathCosts<words>& path, bool with_road) const {
    std::uint32_t* const labels{volume + place(i)};
    for (int k{0}; k < words; ++k) {
      if (has_upright(k)) labels[lane_ + 32 * k] = packed(path.upright, k);
    }
    if (with_road && has_road()) labels[problem_.volume.upright_words + lane_] = packed(path.road, 0);
  }

 private:
  [[nodiscard]] __device__ std::size_t place(int i) const {
    return static_cast<std::size_t>(pixel(i)) * static_cast<std::size_t>(problem_.volume.words);
  }
  [[nodiscard]] __device__ bool has_upright(int k) const { return lane_ + 32 * k < problem_.volume.upright_words; }
  [[nodiscard]] __device__ bool has_road() const {
    return lane_ + problem_.volume.upright_words < problem_.volume.words;
  }

  const Problem& problem_;
  int lane_;
  int length_;
  int first_;
  int step_;
};

// Goes along a line: visit(i, input of step i), with inputs loaded `ahead` steps before they are needed.
template <int ahead, class Load, class Visit>
__device__ void walk(int length, const Load& load, const Visit& visit) {
  decltype(load(0)) next[ahead];
  for (int k{0}; k < ahead; ++k) next[k] = load(min(k, length - 1));
  for (int first{0}; first < length; first += ahead) {
    STEREOGRID_UNROLL
    for (int k{0}; k < ahead; ++k) {
      if (first + k >= length) return;
      const auto now = next[k];
      next[k] = load(min(first + k + ahead, length - 1));
      visit(first + k, now);
    }
  }
}

// blockIdx.x: the row, blockIdx.y: from the left or the right.
template <int words>
__global__ void __launch_bounds__(32) walk_paths(Problem problem) {
  __shared__ ChangeRoom room;
  const Line line{problem, Direction{blockIdx.y == 0 ? 1 : -1, 0}, static_cast<int>(blockIdx.x)};
  std::uint32_t* const volume{problem.paths[blockIdx.y]};
  PathCosts<words> path;
  walk<4>(
      line.length(), [&](int i) { return line.costs<words>(i); },
      [&](int i, const PixelCosts<words>& pixel) {
        path = i == 0 ? first_costs(pixel) : advance<false>(path, pixel, problem.penalties, room);
        line.store(volume, i, path, pixel.meeting != no_road);
      });
}

template <int words>
struct LastInput {
  PixelCosts<words> pixel;
  std::uint32_t upright[volumes][words];
  std::uint32_t road[volumes];
};

template <int words>
__device__ LastInput<words> last_input(const Problem& problem, const Line& line, int i) {
  LastInput<words> input;
  input.pixel = line.costs<words>(i);
  for (int k{0}; k < volumes; ++k) line.load(problem.paths[k], i, input.upright[k], input.road[k]);
  return input;
}

// Sums stop at cost_max.
template <int words>
__device__ PathCosts<words> sum_of(const LastInput<words>& input, PathCosts<words> sum) {
  for (int k{0}; k < volumes; ++k) {
    for (int i{0}; i < words; ++i) {
      sum.upright.even[i] += even_bytes(input.upright[k][i]);
      sum.upright.odd[i] += odd_bytes(input.upright[k][i]);
    }
    sum.road.even[0] += even_bytes(input.road[k]);
    sum.road.odd[0] += odd_bytes(input.road[k]);
  }
  const auto stop = [](std::uint32_t& costs) { costs = __vminu2(costs, twice(cost_max)); };
  for (int i{0}; i < words; ++i) {
    stop(sum.upright.even[i]);
    stop(sum.upright.odd[i]);
  }
  stop(sum.road.even[0]);
  stop(sum.road.odd[0]);
  return sum;
}

// The last direction.
template <int words>
__global__ void __launch_bounds__(32)
    walk_up(Problem problem, int uniqueness_1024, FoundLabel* upright, FoundLabel* level) {
  __shared__ ChangeRoom room;
  const Line line{problem, upwards, static_cast<int>(blockIdx.x)};
  const BestLabel<32, words> best_upright{problem.upright.count, uniqueness_1024, cost_max};
  const BestLabel<road_lanes, 1> best_road{problem.road.count, uniqueness_1024, cost_max};
  PathCosts<words> path;
  walk<3>(
      line.length(), [&](int i) { return last_input<words>(problem, line, i); },
      [&](int i, const LastInput<words>& input) {
        path = i == 0 ? first_costs(input.pixel) : advance<true>(path, input.pixel, problem.penalties, room);
        const PathCosts<words> sum{sum_of(input, path)};
        const FoundLabel found{best_upright.find(sum.upright)};
        FoundLabel on_road{cost_max, cost_max, cost_max, 0, 1};  // equal costs of all labels
        if (input.pixel.meeting != no_road) on_road = best_road.find(sum.road);
        if (threadIdx.x != 0) return;
        upright[line.pixel(i)] = found;
        level[line.pixel(i)] = on_road;
      });
}

template <int words>
void walk_all(Cuda& cuda, const Problem& problem, int uniqueness, FoundLabel* upright, FoundLabel* level) {
  const auto width = static_cast<unsigned>(problem.width);
  const auto height = static_cast<unsigned>(problem.height);
  launch(cuda, walk_paths<words>, dim3{height, volumes}, dim3{32}, 0, problem);
  launch(cuda, walk_up<words>, dim3{width}, dim3{32}, 0, problem, uniqueness, upright, level);
}

Problem problem_of(SemiGlobalOnDevice& space, const MatchingConfig& config) {
  constexpr Penalties penalties{path_penalties};
  Problem problem{space.meeting.width(),
                  space.meeting.height(),
                  upright_shifts(config),
                  road_shifts,
                  space.volume,
                  {twice(penalties.step), twice(penalties.road_step), twice(penalties.jump), twice(penalties.change)},
                  space.meeting.data(),
                  space.costs.data(),
                  {}};
  for (std::size_t i{0}; i < volumes; ++i) problem.paths[i] = space.paths[i].data();
  return problem;
}

}  // namespace

SemiGlobalOnDevice::SemiGlobalOnDevice(int width, int height, const MatchingConfig& config)
    : census{width, height},
      meeting{width, height},
      volume{upright_shifts(config), road_shifts},
      costs{meeting.size() * static_cast<std::size_t>(volume.words)} {
  for (int i{0}; i < volumes; ++i) paths.emplace_back(costs.size());
}

void optimise(Cuda& cuda, SemiGlobalOnDevice& space, const RoadPlane* plane, const MatchingConfig& config,
              View<FoundLabel, Device> upright, View<FoundLabel, Device> level) {
  constexpr int threads{128};
  const Problem problem{problem_of(space, config)};
  const auto height = static_cast<unsigned>(problem.height);
  launch(cuda, find_meetings, dim3{blocks_for(problem.width, threads), height}, dim3{threads}, 0, space.meeting.view(),
         plane, problem.upright, problem.road);
  const int pixels{cost_threads / problem.volume.words};
  const dim3 block{static_cast<unsigned>(problem.volume.words), static_cast<unsigned>(pixels)};
  launch(cuda, find_costs, dim3{blocks_for(problem.width, pixels), height}, block, 0, problem, space.census.left.view(),
         space.census.right.view(), space.census.sheared.view());
  if (problem.upright.count <= 128) {
    walk_all<1>(cuda, problem, uniqueness_1024(config), upright.data, level.data);
  } else {
    walk_all<2>(cuda, problem, uniqueness_1024(config), upright.data, level.data);
  }
}

}  // namespace stereogrid
