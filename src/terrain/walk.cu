// SPDX-License-Identifier: Apache-2.0
//
// The walk over the ground on the device.
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "backend/warp.cuh"
#include "numbers.hpp"
#include "terrain/cuda.hpp"
#include "terrain/settle.hpp"
#include "terrain/walk_steps.hpp"

namespace stereogrid {
namespace {

constexpr int threads{256};
// As many as registers allow: lanes of a warp that take different paths wait for each other.
constexpr int spread_threads{512};
constexpr int spread_warps{spread_threads / warp};

// The device's memory as its own code sees it.
template <class T>
STEREOGRID_HD View<T> seen(View<T, Device> there) {
  return {there.data, there.width, there.height, there.pitch};
}

SampleTable samples_of(TerrainOnDevice& terrain) {
  return {terrain.frame.ground,        seen(std::as_const(terrain.medians).view()),
          seen(terrain.x.view()),      seen(terrain.z.view()),
          seen(terrain.next.view()),   seen(terrain.first.view()),
          seen(terrain.spread.view()), seen(terrain.upright.view())};
}

// A block per sector: a thread per row, then a thread per ring, which passes over all rows.
__global__ void place_samples(SampleTable table, RingTable rings, SectorRows* rows) {
  const int sector{static_cast<int>(blockIdx.x)};
  const int t{static_cast<int>(threadIdx.x)};
  const SectorRows s{table.rows_of(sector)};
  if (t == 0) rows[sector] = s;
  float* const differences{dynamic_shared<float>()};
  std::int16_t* const ring_of{reinterpret_cast<std::int16_t*>(differences + s.end_row)};
  const bool is_last{sector + 1 == table.sectors()};
  const float* const beside{table.medians.row(is_last ? sector : sector + 1)};
  for (int v{s.first_row + t}; v < s.end_row; v += threads) {
    const float there{s.disparity[v]};
    SampleTable::place(there, v, table.ground.camera.focal_baseline_pxm, table.ground.camera.height_m, s);
    s.upright[v] = s.is_upright(v, table.ground.camera, table.ground.limits.slope);
    ring_of[v] = static_cast<std::int16_t>(SampleTable::ring_of(there, rings));
    differences[v] = is_last ? SampleTable::spread_max_px : SampleTable::difference(there, beside[v], table.roll_px());
  }
  __syncthreads();
  for (int ring{t}; ring < rings.count(); ring += threads) {
    RingSpread spread{};
    int first{no_row};
    for (int v{s.first_row}; v < s.end_row; ++v) {
      if (ring_of[v] != ring) continue;
      s.next[v] = static_cast<std::int16_t>(first);
      first = v;
      if (!(differences[v] < SampleTable::spread_max_px)) continue;
      spread.sum += differences[v];
      spread.count += 1;
    }
    s.first[ring] = static_cast<std::int16_t>(first);
    table.spread(ring, sector) = spread;
  }
}

// One block: a thread per ring, then one for all.
__global__ void measure_noise(SampleTable table, RingTable rings, float* sigma_px, int* checked_rings) {
  RingSpread* const spreads{dynamic_shared<RingSpread>()};
  for (int ring{static_cast<int>(threadIdx.x)}; ring < rings.count(); ring += threads)
    spreads[ring] = table.spread_of(ring);
  __syncthreads();
  if (threadIdx.x != 0) return;
  for (int ring{0}; ring < rings.count(); ++ring) sigma_px[ring] = SampleTable::noise_of(ring, spreads[ring], sigma_px);
  *checked_rings = checked_rings_of(table.ground, rings, sigma_px);
}

// A block of one thread per sector: lanes of a warp would wait for each other's paths.
__global__ void walk_sectors(WalkInput input, const int* checked_rings, const std::optional<Trench>* trenches,
                             View<PolarCell, Device> cells, View<SectorWalk, Device> walks) {
  const int sector{static_cast<int>(blockIdx.x)};
  input.checked_rings = *checked_rings;
  walk_sector(input, sector, trenches[sector], seen(cells), walks(sector, 0));
}

// Number of the bits `from` to `end` − 1 that are set.
__device__ int count_bits(const unsigned* words, int from, int end) {
  int count{0};
  for (int bit{from}; bit < end;) {
    const int next{Min(bit / warp * warp + warp, end)};
    const unsigned of_word{words[bit / warp] >> (bit % warp)};
    count += __popc(of_word & (whole_warp >> (warp - (next - bit))));
    bit = next;
  }
  return count;
}

// The last bit before `bit` that is set, or −1.
__device__ int set_before(const unsigned* words, int bit) {
  int word{bit / warp};
  unsigned bits{words[word] & ((1U << (bit % warp)) - 1)};
  while (bits == 0 && word > 0) bits = words[--word];
  return bits == 0 ? -1 : word * warp + warp - 1 - __clz(static_cast<int>(bits));
}

// The first bit from `bit` on that is set; one behind the last word is.
__device__ int set_from(const unsigned* words, int bit) {
  int word{bit / warp};
  unsigned bits{words[word] & (whole_warp << (bit % warp))};
  while (bits == 0) bits = words[++word];
  return word * warp + __ffs(static_cast<int>(bits)) - 1;
}

// hide_unconnected() of the CPU, by one block: a lane per sector, in words of a warp. `masks`: three of sectors + 1
// bits.
__device__ void hide_in_words(const WalkInput& input, View<PolarCell> cells, unsigned* masks) {
  const int words{cells.height / warp + 1};
  unsigned* const behind{masks};
  unsigned* reached{masks + words};  // in the ring before
  unsigned* reached_now{reached + words};
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const auto for_words = [&](const auto& work) {
    for (int word{static_cast<int>(threadIdx.x) / warp}; word < words; word += spread_warps)
      work(word, word * warp + lane);
    __syncthreads();
  };
  for_words([&](int word, int) { reached[word] = whole_warp; });
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    const RingWays ways{input, ring};
    for_words([&](int word, int sector) {
      const unsigned bits{__ballot_sync(whole_warp, sector >= cells.height || is_behind_edge(cells(ring, sector)))};
      if (lane == 0) behind[word] = bits;
    });
    for_words([&](int word, int sector) {
      bool is_reached{false};
      if (sector < cells.height && !is_behind_edge(cells(ring, sector))) {
        const int begin{set_before(behind, sector) + 1};
        const int end{set_from(behind, sector)};
        is_reached = count_bits(reached, Min(Max(ways.first, begin), end), end) >= ways.narrowest;
      }
      const unsigned bits{__ballot_sync(whole_warp, is_reached)};
      if (lane == 0) reached_now[word] = bits;
    });
    for_words([&](int word, int sector) {
      const bool is_lost{(behind[word] >> lane & 1U) == 0 && (reached_now[word] >> lane & 1U) == 0};
      if (is_lost && cells(ring, sector).is_ground()) cells(ring, sector) = PolarCell{.kind = TerrainClass::hidden};
    });
    unsigned* const before{reached};
    reached = reached_now;
    reached_now = before;
  }
}

// SectorWalks::spread_ground, by one block, a thread per sector. Neighbours are in different warps.
__global__ void spread_ground(WalkInput input, const int* checked_rings, View<PolarCell, Device> of_frame,
                              View<SectorWalk, Device> walks_of_frame) {
  input.checked_rings = *checked_rings;
  const View<PolarCell> cells{seen(of_frame)};
  const View<SectorWalk> walks{seen(walks_of_frame)};
  const int t{static_cast<int>(threadIdx.x) % warp * spread_warps + static_cast<int>(threadIdx.x) / warp};
  const auto for_all = [&](const auto& work) {
    for (int sector{t}; sector < input.sectors; sector += spread_threads) work(sector, walks(sector, 0));
    __syncthreads();
  };
  for_all([&](int sector, SectorWalk&) { confirm_block(sector, walks); });
  for_all([&](int sector, SectorWalk& walk) { drop_lone_obstacle(cells.row(sector), walk); });
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    for_all([&](int sector, SectorWalk& walk) { step_on(input, sector, ring, cells, walk); });
    for (bool is_changed{true}; is_changed;) {
      int has_taken{0};
      for (int sector{t}; sector < input.sectors; sector += spread_threads)
        has_taken |= take_over(input, sector, ring, cells, walks) ? 1 : 0;
      is_changed = __syncthreads_or(has_taken) != 0;
      if (is_changed) for_all([&](int sector, SectorWalk& walk) { settle_taken(sector, ring, cells, walk); });
    }
  }
  for_all([&](int sector, SectorWalk&) { settle_sector(sector, walks, input.rings.count(), cells.row(sector)); });
  for (int ring{t}; ring < input.rings.count(); ring += spread_threads) {
    spread_hidden(ring, cells);
    fill_streaks(input, ring, walks, cells);
  }
  __syncthreads();
  hide_in_words(input, cells, dynamic_shared<unsigned>());
  for (int ring{t}; ring < input.rings.count(); ring += spread_threads) hide_ends(input, ring, cells);
}

std::size_t times(std::size_t a, int b) {
  return a * static_cast<std::size_t>(b);
}

}  // namespace

TerrainOnDevice::TerrainOnDevice(Cuda& cuda, const Rig& level_rig, int window, const Rings& of_config)
    : window_px{window},
      medians{level_rig.height_px, terrain_sectors(level_rig.width_px)},
      shapes{trench_shapes},
      trenches{static_cast<std::size_t>(medians.height())},
      borders_m{static_cast<std::size_t>(of_config.capacity()) + 1},
      ring_at{static_cast<std::size_t>(of_config.places()) + 1},
      x{medians.width(), medians.height()},
      z{medians.width(), medians.height()},
      next{medians.width(), medians.height()},
      first{of_config.capacity(), medians.height()},
      spread{of_config.capacity(), medians.height()},
      upright{medians.width(), medians.height()},
      rows{trenches.size()},
      sigma_px{borders_m.size()},
      checked_rings{1},
      cells{times(trenches.size(), of_config.capacity())},
      walks{trenches.size()},
      host_borders_m{borders_m.size()},
      host_ring_at{ring_at.size()},
      host_sigma_px{sigma_px.size()},
      host_cells{cells.size()},
      host_walks{walks.size()} {
  const std::vector<TrenchShape> by_rows{trench_shapes_of(window_px)};
  upload(cuda, by_rows.data(), by_rows.size(), shapes.data());
  cuda.synchronize();
}

void begin_walk(Cuda& cuda, const WalkFrame& frame, TerrainOnDevice& terrain) {
  const RingTable& rings{frame.rings};
  std::copy_n(rings.borders_m, rings.count() + 1, terrain.host_borders_m.data());
  std::copy_n(rings.ring_at, rings.places() + 1, terrain.host_ring_at.data());
  upload(cuda, terrain.host_borders_m.data(), static_cast<std::size_t>(rings.count()) + 1, terrain.borders_m.data());
  upload(cuda, terrain.host_ring_at.data(), terrain.ring_at.size(), terrain.ring_at.data());
  terrain.frame = {
      frame.ground, {rings.count(), rings.places(), terrain.borders_m.data(), terrain.ring_at.data()}, frame.prior};
  const SampleTable table{samples_of(terrain)};
  const std::size_t row_bytes{sizeof(float) + sizeof(std::int16_t)};
  launch(cuda, place_samples, table.sectors(), threads, times(row_bytes, table.medians.width), table,
         terrain.frame.rings, terrain.rows.data());
  launch(cuda, measure_noise, 1, threads, times(sizeof(RingSpread), rings.count()), table, terrain.frame.rings,
         terrain.sigma_px.data(), terrain.checked_rings.data());
  download(cuda, terrain.sigma_px.data(), static_cast<std::size_t>(rings.count()), terrain.host_sigma_px.data());
}

void find_walk(Cuda& cuda, TerrainOnDevice& terrain) {
  const WalkFrame& frame{terrain.frame};
  const int sectors{terrain.medians.height()};
  const int rings{frame.rings.count()};
  const WalkInput input{frame.ground.camera,
                        frame.ground.limits,
                        frame.rings,
                        terrain.rows.data(),
                        sectors,
                        terrain.sigma_px.data(),
                        0,
                        static_cast<float>(terrain.window_px),
                        frame.prior};
  const View<PolarCell, Device> cells{terrain.cells.data(), rings, sectors, rings};
  const View<SectorWalk, Device> walks{terrain.walks.data(), sectors, 1, sectors};
  launch(cuda, walk_sectors, sectors, 1, 0, input, terrain.checked_rings.data(), terrain.trenches.data(), cells, walks);
  launch(cuda, spread_ground, 1, spread_threads, times(3 * sizeof(unsigned), sectors / warp + 1), input,
         terrain.checked_rings.data(), cells, walks);
  terrain.walked = {cells, walks, terrain.sigma_px.data()};
  download(cuda, cells.data, times(static_cast<std::size_t>(sectors), rings), terrain.host_cells.data());
  download(cuda, walks.data, terrain.walks.size(), terrain.host_walks.data());
}

}  // namespace stereogrid
