// SPDX-License-Identifier: Apache-2.0
#include "backend/warp.cuh"
#include "observation/u_disparity/cuda.hpp"

namespace stereogrid {
namespace {

// A block has 32 columns, a lane each, and all their rows.
constexpr int count_warps{32};
constexpr int rows_at_once{4};

struct Counting {
  int disparities;
  bool road_rays;
};

// The counts of 32 columns in shared memory. A word is N_O·65536 + N_V, N_V as differences from one bin to the next;
// what N_V borrows from N_O is given back when they are added up, since N_V itself is known to fit 16 bits.
struct ColumnCounts {
  unsigned* words;  // [bin][32]
  unsigned* marks;  // [bin / 32][32] a bit per bin with a road pixel
  int disparities;

  __device__ ColumnCounts(unsigned* memory, int bins) : words{memory}, marks{memory + bins * warp}, disparities{bins} {}
  [[nodiscard]] static __host__ __device__ int size(int disparities) {
    return (disparities + (disparities + warp - 1) / warp) * warp;
  }

  // A ray that ends in `bin`, of a row that is possible for `bins`.
  __device__ void arrive(int bin, const BinRange& bins, bool is_observed, int lane) {
    const int from{bin < bins.first ? bins.first : bin};
    if (from > bins.last) return;
    atomicAdd(&words[from * warp + lane], is_observed ? 1u << 16 | 1u : 1u);
    if (bins.last + 1 < disparities) atomicSub(&words[(bins.last + 1) * warp + lane], 1u);
  }
  __device__ void mark(int bin, int lane) { atomicOr(&marks[bin / warp * warp + lane], 1u << bin % warp); }
};

// A pixel and the bins of its row.
struct Pixel {
  float obstacle;
  float road;
  BinRange bins;
  BinRange upright_bins;
};

__device__ void count_pixel(const Counting& counting, const Pixel& pixel, int lane, ColumnCounts& counts) {
  const int upright_bin{bin_of(pixel.obstacle)};
  const int road_bin{bin_of(pixel.road)};
  if (upright_bin > 0) {
    const bool is_observed{upright_bin >= pixel.upright_bins.first && upright_bin <= pixel.upright_bins.last};
    counts.arrive(upright_bin, pixel.bins, is_observed, lane);
  } else if (road_bin > 0) {
    if (road_bin < counting.disparities) counts.mark(road_bin, lane);
    if (counting.road_rays) counts.arrive(road_bin, pixel.bins, false, lane);
  }
}

__device__ void count_rows(const Counting& counting, const MatchViews& matches, const BinRowsOnDevice& rows, int u,
                           int lane, ColumnCounts& counts) {
  const int first{rows.margin - rows.shift[u]};
  const int height{matches.obstacle.height};
  for (int begin{static_cast<int>(threadIdx.x) / warp}; begin < height; begin += count_warps * rows_at_once) {
    Pixel pixels[rows_at_once];
    for (int k{0}; k < rows_at_once; ++k) {  // loads all of them before the first use
      const int at_most{begin + k * count_warps};
      const int v{at_most < height ? at_most : height - 1};
      pixels[k] = {matches.obstacle(u, v), matches.road(u, v), rows.bins[first + v], rows.upright_bins[first + v]};
    }
    for (int k{0}; k < rows_at_once && begin + k * count_warps < height; ++k) {
      count_pixel(counting, pixels[k], lane, counts);
    }
  }
}

// A warp adds up a share of the bins, after the shares of the warps before it.
__global__ void __launch_bounds__(count_warps* warp)
    count_block(Counting counting, MatchViews matches, BinRowsOnDevice rows, View<std::uint16_t, Device> visible,
                View<std::uint16_t, Device> observed, View<std::uint8_t, Device> has_road) {
  __shared__ unsigned share[count_warps][warp];
  ColumnCounts counts{dynamic_shared<unsigned>(), counting.disparities};
  for (int i{static_cast<int>(threadIdx.x)}; i < ColumnCounts::size(counting.disparities); i += count_warps * warp) {
    counts.words[i] = 0;
  }
  __syncthreads();
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const int w{static_cast<int>(threadIdx.x) / warp};
  const int u{static_cast<int>(blockIdx.x) * warp + lane};
  if (u < visible.width) count_rows(counting, matches, rows, u, lane, counts);
  __syncthreads();
  const int bins{(counting.disparities + count_warps - 1) / count_warps};
  const int begin{w * bins};
  const int end{begin + bins < counting.disparities ? begin + bins : counting.disparities};
  unsigned sum{0};
  for (int d{begin}; d < end; ++d) sum += counts.words[d * warp + lane];
  share[w][lane] = sum;
  __syncthreads();
  unsigned rays{0};
  for (int before{0}; before < w; ++before) rays += share[before][lane];
  rays &= 0xffffu;
  if (u >= visible.width) return;
  for (int d{begin}; d < end; ++d) {
    const unsigned word{counts.words[d * warp + lane]};
    const unsigned rays_here{(rays + word) & 0xffffu};
    visible(u, d) = static_cast<std::uint16_t>(rays_here);
    observed(u, d) = static_cast<std::uint16_t>((word - (rays_here - rays)) >> 16);
    has_road(u, d) = static_cast<std::uint8_t>(counts.marks[d / warp * warp + lane] >> d % warp & 1u);
    rays = rays_here;
  }
}

}  // namespace

void count_columns(Cuda& cuda, const MatchViews& matches, const BinRowsOnDevice& rows, UDisparityOnDevice& space) {
  const BinConfig& config{space.config};
  const int disparities{space.occupancy.height()};
  launch(cuda, count_block, blocks_for(matches.road.width, warp), count_warps * warp,
         static_cast<std::size_t>(ColumnCounts::size(disparities)) * sizeof(unsigned),
         Counting{disparities, config.road_rays == RoadRays::visible}, matches, rows, space.visible.view(),
         space.observed.view(), space.has_road.view());
}

}  // namespace stereogrid
