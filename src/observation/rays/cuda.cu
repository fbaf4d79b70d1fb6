// SPDX-License-Identifier: Apache-2.0
#include "observation/rays/cuda.hpp"

#include "backend/warp.cuh"

namespace stereogrid {
namespace {

constexpr int threads{128};
constexpr int block_width{32};
constexpr int block_height{4};
constexpr int lines{4};  // lines summed by a block
constexpr int line_threads{32};

struct Placement {
  double highest_m;
  double lowest_m;
  double cx_px;
  bool follow_roll;
};

// RayWorkspace::place. A thread per column, and per row.
__global__ void place(Placement placement, Rig rig, const Ground* ground, int width, int rows, int margin, int bins,
                      std::int32_t* shift, RayRow* out, UprightRange* upright) {
  const int i{static_cast<int>(blockIdx.x * threads + threadIdx.x)};
  if (i == 0) *upright = upright_range(ground->height_m, placement.lowest_m, placement.highest_m);
  if (i < width) {
    const double slope{placement.follow_roll ? -tan(ground->roll_rad) : 0.0};
    shift[i] = row_shift(slope, i - placement.cx_px, largest_shift(width));
  }
  if (i < rows) out[i] = ray_row(RowsByHeight{rig, *ground}, placement.highest_m, i - margin, bins);
}

struct Counting {
  Relief<Device> relief;
  const std::int32_t* shift;
  const RayRow* rows;
  const UprightRange* upright;
  PackedRays* sums;
  int margin;
  int bins;
};

// A thread per pixel.
__global__ void count_pixels(Counting counting, MatchViews matches) {
  const int u{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int v{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  const int width{matches.road.width};
  if (u >= width || v >= matches.road.height) return;
  const float obstacle{matches.obstacle(u, v)};
  const float road{matches.road(u, v)};
  const int raised{counting.relief.is_plane() ? 0 : counting.relief.rows_at(u, obstacle > 0 ? obstacle : road)};
  count_ray(obstacle, road, counting.rows[v + counting.margin - counting.shift[u] + raised], *counting.upright,
            counting.bins, [&](int bin, PackedRays rays) {
              atomicAdd(reinterpret_cast<unsigned long long*>(&counting.sums[(u + 1) * (counting.bins + 1) + bin + 1]),
                        rays);
            });
}

// Sums of `count` numbers that lie `apart`, in place: each thread of a line adds up a share of them, behind the shares
// before. `shares`: of the line's threads.
__device__ void sum_line(PackedRays* numbers, int count, int apart, int t, PackedRays (&shares)[line_threads]) {
  const int share{(count + line_threads - 1) / line_threads};
  const int begin{t * share < count ? t * share : count};
  const int end{begin + share < count ? begin + share : count};
  PackedRays sum{0};
  for (int i{begin}; i < end; ++i) sum += numbers[i * apart];
  shares[t] = sum;
  __syncthreads();
  PackedRays before{0};
  for (int i{0}; i < t; ++i) before += shares[i];
  for (int i{begin}; i < end; ++i) numbers[i * apart] = before += numbers[i * apart];
}

// Sums over the bins of a column, by threads side by side.
__global__ void sum_bins(PackedRays* sums, int columns, int bins) {
  __shared__ PackedRays shares[lines][line_threads];
  const int u{static_cast<int>(blockIdx.x) * lines + static_cast<int>(threadIdx.y)};
  sum_line(sums + u * bins, u < columns ? bins : 0, 1, static_cast<int>(threadIdx.x), shares[threadIdx.y]);
}

// opaque_bins by a warp, which reads the rows of as many lanes at once. All lanes have the result.
template <class Pixel, class Row>
__device__ int opaque_bins_by_warp(int height, const UprightRange& range, const Pixel& pixel, const Row& row) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const auto lanes = [](bool is_one) { return __ballot_sync(whole_warp, is_one ? 1 : 0); };
  const auto is_ambiguous_at = [&](int v) { return v >= 0 && is_ambiguous(pixel(v)); };
  const auto count = [&](int v, float top) {
    PatternRows seen{0, 0};
    unsigned outside{0};
    for (int lowest{v}; outside == 0; lowest -= warp) {
      outside = lanes(lowest < lane || row(lowest - lane).drop < top);
      const unsigned inside{outside == 0 ? whole_warp : (outside & (0U - outside)) - 1};  // before the first outside
      seen.rows += __popc(inside);
      seen.ambiguous += __popc(inside & lanes(is_ambiguous_at(lowest - lane)));
    }
    return seen;
  };
  for (int lowest{height - 1}; lowest >= 0; lowest -= warp) {
    for (unsigned ambiguous{lanes(is_ambiguous_at(lowest - lane))}; ambiguous != 0; ambiguous &= ambiguous - 1) {
      const int v{lowest - (__ffs(static_cast<int>(ambiguous)) - 1)};
      const int bins{bins_to_foot(v, height, range, row, count)};
      if (bins != no_foot) return bins;
    }
  }
  return 0;
}

// RayWorkspace::stop_at_pattern. A warp per column.
__global__ void stop_at_patterns(Counting counting, MatchViews matches) {
  const int u{static_cast<int>(blockIdx.x * threads + threadIdx.x) / warp};
  if (u >= matches.road.width) return;
  const auto row = [&](int v) -> const RayRow& {
    const RayRow* const on_plane{counting.rows + v + counting.margin - counting.shift[u]};
    if (counting.relief.is_plane()) return *on_plane;
    return on_plane[counting.relief.rows_at(u, static_cast<float>(on_plane->first) / ray_bins_per_px)];
  };
  const int bins{opaque_bins_by_warp(
      matches.road.height, *counting.upright, [&](int v) { return matches.obstacle(u, v); }, row)};
  stop_rays(bins, counting.sums + (u + 1) * (counting.bins + 1), static_cast<int>(threadIdx.x) % warp, warp);
}

// Sums over the columns of a bin; neighbouring threads read neighbouring bins.
__global__ void sum_columns(PackedRays* sums, int columns, int bins) {
  __shared__ PackedRays shares[lines][line_threads];
  const int k{static_cast<int>(blockIdx.x) * lines + static_cast<int>(threadIdx.x)};
  sum_line(sums + k, k < bins ? columns : 0, bins, static_cast<int>(threadIdx.y), shares[threadIdx.x]);
}

__global__ void project_cells(RaySums<Device> sums, int most_columns, BinGeometry geometry, const GridInVehicle* grid,
                              const float* blur_px, View<float, Device> cells) {
  const int ix{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  if (ix >= cells.width || iy >= cells.height) return;
  cells(ix, iy) = occupancy_at(sums, most_columns, CellsInView{geometry, *grid, *blur_px}, ix, iy);
}

dim3 blocks_of(int width, int height) {
  return {blocks_for(width, block_width), blocks_for(height, block_height)};
}

std::size_t size_if(bool is_wanted, int size) {
  return is_wanted ? static_cast<std::size_t>(size) : 0;
}

}  // namespace

RaysOnDevice::RaysOnDevice(int image_width, int image_height, int disparities, bool has_relief)
    : width{image_width},
      height{image_height},
      bins{disparities * ray_bins_per_px},
      margin{largest_shift(image_width) + (has_relief ? image_height : 0)},
      shift{size_if(bins > 0, width)},
      rows{size_if(bins > 0, height + 2 * margin)},
      upright{1},
      relief{size_if(has_relief, bins * relief_sectors(width))},
      sums{size_if(bins > 0, (bins + 1) * (width + 1))} {}

void begin_rays(Cuda& cuda, const Rig& rig, const Ground* ground, const UDisparityConfig& config, RaysOnDevice& space) {
  const int rows{static_cast<int>(space.rows.size())};
  launch(cuda, place, blocks_for(space.width > rows ? space.width : rows, threads), threads, 0,
         Placement{config.obstacle_height_m, config.obstacle_min_height_m, rig.cx_px, config.follow_roll}, rig, ground,
         space.width, rows, space.margin, space.bins, space.shift.data(), space.rows.data(), space.upright.data());
  clear(cuda, space.sums.data(), space.sums.size());
}

void count_rays(Cuda& cuda, const MatchViews& matches, RaysOnDevice& space) {
  const int columns{space.width + 1};
  const int bins{space.bins + 1};
  const Counting counting{space.relief_view(), space.shift.data(), space.rows.data(), space.upright.data(),
                          space.sums.data(),   space.margin,       space.bins};
  launch(cuda, count_pixels, blocks_of(space.width, space.height), dim3{block_width, block_height}, 0, counting,
         matches);
  launch(cuda, sum_bins, blocks_for(columns, lines), dim3{line_threads, lines}, 0, space.sums.data(), columns, bins);
  launch(cuda, stop_at_patterns, blocks_for(space.width * warp, threads), threads, 0, counting, matches);
  launch(cuda, sum_columns, blocks_for(bins, lines), dim3{lines, line_threads}, 0, space.sums.data(), columns, bins);
}

void project_rays(Cuda& cuda, const RaysOnDevice& space, const BinGeometry& geometry, const GridInVehicle* grid,
                  const float* blur_px, View<float, Device> cells) {
  launch(cuda, project_cells, blocks_of(cells.width, cells.height), dim3{block_width, block_height}, 0, space.view(),
         columns_max(space.height), geometry, grid, blur_px, cells);
}

}  // namespace stereogrid
