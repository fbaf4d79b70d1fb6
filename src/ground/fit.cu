// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/cuda.hpp"

#include <utility>

#include "backend/warp.cuh"

namespace stereogrid {
namespace {

// One block does the whole fit; a warp of it reads whole blocks of the image.
constexpr int fit_warps{32};
constexpr int fit_threads{fit_warps * warp};
constexpr int sums_max{16};
constexpr int bins_each{(residual_bins + warp - 1) / warp};

// Parts of the lattice, each of which a warp reads at a time.
struct Parts {
  int columns;
  int rows;
};
constexpr Parts image_blocks{block_u_px / lattice_px, block_v_px / lattice_px};
constexpr Parts strips{warp, 4};  // parts without a relation to image blocks: no lane is idle

// A sample as the fit sees it.
struct Sample {
  float r;
  float u;
  float v;
};

// The samples of a fit, and the plane it has come to: `moved` from the expected one.
struct Lattice {
  const float* residual;
  int width;
  int height;
  int first_row;
  float cx_px;
  float cy_px;
  float moved[3];

  [[nodiscard]] __device__ int across(Parts parts) const { return (width - 1) / parts.columns + 1; }

  // Calls visit(Sample) for this lane's samples, and end() behind each of this warp's parts. Those that lie above the
  // first row have none.
  template <Parts parts, class Visit, class End>
  __device__ void for_samples(const Visit& visit, const End& end) const {
    static_assert(parts.columns <= warp);
    const int lane{static_cast<int>(threadIdx.x) % warp};
    const int count{across(parts) * ((height - 1) / parts.rows + 1)};
    const int first{first_row / parts.rows * across(parts)};
    for (int part{first + static_cast<int>(threadIdx.x) / warp}; part < count; part += fit_warps) {
      const int i{part % across(parts) * parts.columns + lane};
      if (lane < parts.columns && i < width) for_column<parts.rows>(i, part / across(parts) * parts.rows, visit);
      end();
    }
  }
  template <Parts parts, class Visit>
  __device__ void for_samples(const Visit& visit) const {
    for_samples<parts>(visit, [] {});
  }

 private:
  template <int rows, class Visit>
  __device__ void for_column(int i, int begin, const Visit& visit) const {
    const float u{(static_cast<float>(i * lattice_px + lattice_px / 2) - cx_px) * 0.01f};
    float from_expected[rows];
    for (int k{0}; k < rows; ++k) {  // all loads are issued before the first is needed
      const int j{begin + k};
      from_expected[k] = j >= first_row && j < height ? residual[j * width + i] : no_ground_sample;
    }
    const float along{moved[0] + moved[1] * u};
    for (int k{0}; k < rows; ++k) {
      if (from_expected[k] == no_ground_sample) continue;
      const float v{(static_cast<float>((begin + k) * lattice_px + lattice_px / 2) - cy_px) * 0.01f};
      visit(Sample{from_expected[k] - (along + moved[2] * v), u, v});
    }
  }
};

struct FitSpace {
  float of_warp[fit_warps][sums_max];
  double total[sums_max];
  int counts[residual_bins][warp];  // a column per lane, so that the lanes of a warp do not meet
  int in_bin[residual_bins];
  double radius_px;  // not beside what the threads read while the first one writes this: loads are of 16 bytes
  Matrix3 tether;
  double plane[3];  // at_centre, per_u, per_v
  float moved[3];   // difference of its numbers from the expected ones
  double largest_step;
};

// total[k] = Σ over all threads of sums[k]. A thread's and a warp's are of few samples, for which single precision
// does; many machines have little of double precision.
template <int count>
__device__ void add_up(float (&sums)[count], FitSpace& space) {
  static_assert(count <= sums_max);
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const int w{static_cast<int>(threadIdx.x) / warp};
  const float sum{sums_of_warp(sums)};
  if (lane < count) space.of_warp[w][lane] = sum;
  __syncthreads();
  if (w < count) {
    const double of_all{sum_of_warp(static_cast<double>(space.of_warp[lane][w]))};
    if (lane == 0) space.total[w] = of_all;
  }
  __syncthreads();
}

// 1 − t of Tukey's weight (1 − t)²; below 0: none.
__device__ float rest_of(const Sample& sample, float per_square_px) {
  return 1 - sample.r * sample.r * per_square_px;
}

__device__ float per_square_px(const FitSpace& space) {
  return static_cast<float>(1 / (space.radius_px * space.radius_px));
}

// median_bin of fit_model.hpp, by a warp: as many bins as have, with those below, less than half of all.
__device__ void find_median(FitSpace& space) {
  const int lane{static_cast<int>(threadIdx.x)};
  int below[bins_each];
  int sum{0};
  for (int i{0}; i < bins_each; ++i) {
    const int bin{bins_each * lane + i};
    below[i] = sum += bin < residual_bins ? space.in_bin[bin] : 0;
  }
  int before{sum};
  for (int apart{1}; apart < warp; apart *= 2) {
    const int other{__shfl_up_sync(whole_warp, before, apart)};
    if (lane >= apart) before += other;
  }
  const int total{__shfl_sync(whole_warp, before, warp - 1)};
  int less{0};
  for (const int of_bin : below) less += 2 * (before - sum + of_bin) < total ? 1 : 0;
  const int median{sum_of_warp(less)};
  if (lane == 0) space.radius_px = radius_of_bin(median < residual_bins ? median : residual_bins - 1);
}

__device__ void find_radius(const Lattice& lattice, FitSpace& space) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  for (int i{static_cast<int>(threadIdx.x)}; i < residual_bins * warp; i += fit_threads) {
    space.counts[i / warp][i % warp] = 0;
  }
  __syncthreads();
  lattice.for_samples<strips>([&](const Sample& sample) {
    const float bin{fabsf(sample.r) * residual_bins_per_px};
    if (bin < residual_bins) atomicAdd(&space.counts[static_cast<int>(bin)][lane], 1);
  });
  __syncthreads();
  for (int bin{static_cast<int>(threadIdx.x) / warp}; bin < residual_bins; bin += fit_warps) {
    const int count{sum_of_warp(space.counts[bin][lane])};
    if (lane == 0) space.in_bin[bin] = count;
  }
  __syncthreads();
  if (static_cast<int>(threadIdx.x) < warp) find_median(space);
}

__device__ NormalEquations equations_of(const double* total) {
  NormalEquations equations;
  equations.vector = {{total[0], total[1], total[2]}};
  equations.matrix = {{{{total[3], 0, 0}}, {{total[4], total[5], 0}}, {{total[6], total[7], total[8]}}}};
  equations.inliers = static_cast<int>(total[9]);
  equations.complete();
  return equations;
}

// In the order that equations_of reads.
__device__ void add_to(float (&sums)[sums_max], const Sample& sample, float weight) {
  const float pull{weight * sample.r};
  sums[0] += pull;
  sums[1] += pull * sample.u;
  sums[2] += pull * sample.v;
  sums[3] += weight;
  sums[4] += weight * sample.u;
  sums[5] += weight * sample.u * sample.u;
  sums[6] += weight * sample.v;
  sums[7] += weight * sample.v * sample.u;
  sums[8] += weight * sample.v * sample.v;
  sums[9] += 1;
}

__device__ void sum_round(const Lattice& lattice, FitSpace& space) {
  const float per_square{per_square_px(space)};
  float sums[sums_max]{};
  lattice.for_samples<strips>([&](const Sample& sample) {
    const float rest{rest_of(sample, per_square)};
    if (rest > 0) add_to(sums, sample, rest * rest);
  });
  add_up(sums, space);
}

__device__ RoadPlane plane_of(const FitSpace& space, const RoadPlane& expected) {
  return {space.plane[0], space.plane[1], space.plane[2], expected.cx_px, expected.cy_px};
}

__device__ void move_plane(const RoadPlane& expected, FitSpace& space) {
  RoadPlane plane{plane_of(space, expected)};
  const Vector3 start{numbers_of(expected)};
  space.largest_step = fit_step(equations_of(space.total), space.tether, start, plane);
  space.plane[0] = plane.at_centre;
  space.plane[1] = plane.per_u;
  space.plane[2] = plane.per_v;
  const Vector3 moved{numbers_of(plane) - start};
  for (int i{0}; i < 3; ++i) space.moved[i] = static_cast<float>(moved[i]);
}

struct GroundFit {
  RoadPlane plane;
  FitSums sums;
  int is_determined;
};

// The blocks' shares of the vector, squared; and how many blocks have any. A warp does a block of the image at a time.
__device__ void sum_blocks(const Lattice& lattice, FitSpace& space, GroundFit& fit) {
  const float per_square{per_square_px(space)};
  float sums[8]{};  // six squares, slopes, blocks
  float score[4]{};
  const auto add = [&](const Sample& sample) {
    const float rest{rest_of(sample, per_square)};
    if (!(rest > 0)) return;
    const float pull{rest * rest * sample.r};
    sums[6] += rest * (5 * rest - 4);  // (1 − t)(1 − 5t)
    score[0] += pull;
    score[1] += pull * sample.u;
    score[2] += pull * sample.v;
  };
  const auto end_block = [&] {
    float all[3];
    const float sum{sums_of_warp(score)};
    for (int i{0}; i < 3; ++i) all[i] = __shfl_sync(whole_warp, sum, i);
    for (float& of_next : score) of_next = 0;
    if (threadIdx.x % warp != 0 || (all[0] == 0 && all[1] == 0 && all[2] == 0)) return;
    sums[7] += 1;
    for (int i{0}, k{0}; i < 3; ++i) {
      for (int j{0}; j <= i; ++j) sums[k++] += all[i] * all[j];
    }
  };
  lattice.for_samples<image_blocks>(add, end_block);
  add_up(sums, space);
  if (threadIdx.x != 0) return;
  const double* s{space.total};
  fit.sums.spread = {{{{s[0], s[1], s[3]}}, {{s[1], s[2], s[4]}}, {{s[3], s[4], s[5]}}}};
  fit.sums.slopes = s[6];
  fit.sums.blocks = static_cast<int>(s[7]);
}

// is_lost of ground.hpp, from pixels by their distance; these are 0 afterwards.
__device__ void decide_lost(int* distances, int* lost) {
  __shared__ int here;
  __shared__ int elsewhere;
  const int k{static_cast<int>(threadIdx.x)};
  if (k == 0) here = elsewhere = 0;
  __syncthreads();
  if (k >= 2 && k < distance_bins - 1) {
    const int share{share_around([&](int bin) { return distances[bin]; }, k)};
    atomicMax(is_near_the_plane(k) ? &here : &elsewhere, share);
  }
  __syncthreads();
  if (k < distance_bins) distances[k] = 0;
  if (k == 0) *lost = lies_elsewhere(here, elsewhere) ? 1 : 0;
}

// refine and measure of fit.hpp.
__device__ void fit_plane(const View<const float, Device>& residual, const GroundPrior& prior, FitSpace& space,
                          GroundFit& fit) {
  const bool is_first{threadIdx.x == 0};
  const RoadPlane& expected{prior.expected};
  Lattice lattice{residual.data,
                  residual.width,
                  residual.height,
                  prior.first_row,
                  static_cast<float>(expected.cx_px),
                  static_cast<float>(expected.cy_px),
                  {}};
  if (is_first) {
    space.plane[0] = expected.at_centre;
    space.plane[1] = expected.per_u;
    space.plane[2] = expected.per_v;
    space.tether = tether_of(prior.covariance);
  }
  for (int round{0}; round < fit_rounds_max; ++round) {
    if (is_first) space.radius_px = wide_radius_px(round);
    if (round >= wide_rounds) find_radius(lattice, space);
    __syncthreads();
    sum_round(lattice, space);
    if (is_first) move_plane(expected, space);
    __syncthreads();
    for (int i{0}; i < 3; ++i) lattice.moved[i] = space.moved[i];
    if (space.largest_step < 0 || has_settled(round, space.largest_step)) break;
  }
  sum_round(lattice, space);
  if (is_first) {
    fit.is_determined = space.largest_step < 0 ? 0 : 1;
    fit.plane = plane_of(space, expected);
    fit.sums.equations = equations_of(space.total);
    fit.sums.weights = space.total[3];
  }
  __syncthreads();
  sum_blocks(lattice, space, fit);
}

// By one thread; a call, so that what it spills is not the others' concern.
__device__ __noinline__ void finish(const Rig& rig, const GroundConfig& config, const GroundPrior& prior,
                                    const GroundFit& fit, Ground& ground) {
  PlaneMeasurement measurement;
  const bool is_found{fit.is_determined != 0 && measured(fit.plane, fit.sums, measurement)};
  ground = is_found ? updated(rig, config, prior.before, prior.expected, prior.covariance, measurement) : prior.before;
}

__global__ void __launch_bounds__(fit_threads)
    fit_block(View<const float, Device> residual, Rig rig, GroundConfig config, const GroundPrior* prior,
              int* distances, Ground* ground, int* lost) {
  static_assert(distance_bins <= fit_threads);
  __shared__ FitSpace space;
  __shared__ GroundFit fit;
  decide_lost(distances, lost);
  fit_plane(residual, *prior, space, fit);
  if (threadIdx.x == 0) finish(rig, config, *prior, fit, *ground);
}

}  // namespace

void fit_ground(Cuda& cuda, const Rig& rig, const GroundConfig& config, const GroundPrior* prior, GroundOnDevice& space,
                Ground* ground, int* lost) {
  launch(cuda, fit_block, 1, fit_threads, 0, std::as_const(space.residual).view(), rig, config, prior,
         space.distances.data(), ground, lost);
}

}  // namespace stereogrid
