// SPDX-License-Identifier: Apache-2.0
//
// Window costs without a cost volume. A block computes some rows of 64 columns. Groups of lanes hold the shifts of a
// pixel, four in a word. For each row:
// 1. The differing bits of the row's bytes are added to the sums of the windows' columns, and those of the row that
// leaves the window are subtracted: bytes in shared memory, [column][shift].
// 2. Every group slides over some columns, keeps the window's sums in registers, and finds the best shift.
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"

namespace stereogrid {
namespace {

constexpr int columns{64};  // columns of a block
constexpr int threads{128};
constexpr std::size_t shared_max{48 << 10};
constexpr int level_lanes{2};  // four shifts each
static_assert(road_shifts.count <= 4 * level_lanes);

struct Hypothesis {
  View<const std::uint8_t, Device> right;
  Shifts shifts;
  View<FoundLabel, Device> found;
};

struct Correlation {
  View<const std::uint8_t, Device> left;
  Hypothesis upright;
  Hypothesis level;
  int half_window;
  int rows;  // rows of a block
  int uniqueness_1024;
};

// Layout of shared memory, in words. Columns are counted from the right, so that the shifts of a pixel follow each
// other; four columns' bytes make a word.
struct Room {
  int quads;  // words of a row of the left image
  int right;  // first of the right image's words
  int right_words;
  int sums;

  STEREOGRID_HD Room(int half_window, int rows, int shift_words)
      : quads{(columns + 2 * half_window + 3) / 4},
        right{(rows + 2 * half_window) * quads},
        right_words{quads + shift_words + 1},
        sums{right + (rows + 2 * half_window) * right_words} {}

  [[nodiscard]] std::size_t bytes(int shift_words) const {
    return static_cast<std::size_t>(sums + 4 * quads * shift_words) * sizeof(std::uint32_t);
  }
};

// Number of bits set in each byte.
__device__ inline std::uint32_t bit_counts(std::uint32_t x) {
  x -= x >> 1 & 0x55555555u;
  x = (x & 0x33333333u) + (x >> 2 & 0x33333333u);
  return (x + (x >> 4)) & 0x0f0f0f0fu;
}

template <int lanes, int words>
class Strip {
 public:
  __device__ Strip(const Correlation& task, const Hypothesis& hypothesis, std::uint32_t* memory)
      : task_{task},
        hypothesis_{hypothesis},
        room_{task.half_window, task.rows, lanes * words},
        memory_{memory},
        first_u_{static_cast<int>(blockIdx.x) * columns},
        first_v_{static_cast<int>(blockIdx.y) * task.rows},
        last_column_{first_u_ - task.half_window + 4 * room_.quads - 1},
        lane_{static_cast<int>(threadIdx.x) % lanes},
        group_{static_cast<int>(threadIdx.x) / lanes} {}

  __device__ void run() {
    load();
    __syncthreads();
    add_window();
    __syncthreads();
    const int rows{min(task_.rows, task_.left.height - first_v_)};
    for (int row{0}; row < rows; ++row) {
      finish_row(first_v_ + row);
      if (row + 1 == rows) return;
      __syncthreads();
      slide_window(row);
      __syncthreads();
    }
  }

 private:
  static constexpr int groups{threads / lanes};
  static constexpr int group_columns{columns / groups};
  static_assert(group_columns <= lanes, "each lane keeps one result");

  // All bytes of the two images that the block needs; outside the image the border is repeated.
  __device__ void load() {
    const View<const std::uint8_t, Device>& left{task_.left};
    const int thread{static_cast<int>(threadIdx.x)};
    auto* left_bytes = reinterpret_cast<std::uint8_t*>(memory_);
    auto* right_bytes = reinterpret_cast<std::uint8_t*>(memory_ + room_.right);
    for (int row{0}; row < task_.rows + 2 * task_.half_window; ++row) {
      const int v{clamped(first_v_ - task_.half_window + row, left.height)};
      for (int i{thread}; i < 4 * room_.quads; i += threads) {
        left_bytes[row * 4 * room_.quads + i] = left(clamped(last_column_ - i, left.width), v);
      }
      for (int i{thread}; i < 4 * room_.right_words; i += threads) {
        const int u{clamped(last_column_ - hypothesis_.shifts.first - i, left.width)};
        right_bytes[row * 4 * room_.right_words + i] = hypothesis_.right(u, v);
      }
    }
  }

  // Words of four columns of a row: the left image's and, for a word of shifts, the right image's.
  struct Quad {
    std::uint32_t left;
    std::uint32_t right;
    std::uint32_t right_next;

    // Differing bits of column k of the four and four shifts.
    __device__ std::uint32_t differing(int k) const {
      return bit_counts(__byte_perm(left, 0, 0x1111u * static_cast<unsigned>(k)) ^
                        __funnelshift_r(right, right_next, 8u * static_cast<unsigned>(k)));
    }
  };
  __device__ Quad quad_at(int row, int quad, int word) const {
    const std::uint32_t* right{memory_ + room_.right + row * room_.right_words + quad + word};
    return {memory_[row * room_.quads + quad], right[0], right[1]};
  }

  __device__ std::uint32_t* sums_at(int column, int word) const {
    return memory_ + room_.sums + column * (lanes * words) + word;
  }

  // Columns' sums for the block's first row.
  __device__ void add_window() {
    for (int quad{group_}; quad < room_.quads; quad += groups) {
      for (int i{0}; i < words; ++i) {
        const int word{lane_ + i * lanes};
        std::uint32_t sums[4]{};
        for (int row{0}; row <= 2 * task_.half_window; ++row) {
          const Quad added{quad_at(row, quad, word)};
          for (int k{0}; k < 4; ++k) sums[k] += added.differing(k);
        }
        for (int k{0}; k < 4; ++k) *sums_at(4 * quad + k, word) = sums[k];
      }
    }
  }

  // From a row of the block to the next one. No byte overflows on the way from one sum to the next.
  __device__ void slide_window(int row) {
    for (int quad{group_}; quad < room_.quads; quad += groups) {
      for (int i{0}; i < words; ++i) {
        const int word{lane_ + i * lanes};
        const Quad added{quad_at(row + 2 * task_.half_window + 1, quad, word)};
        const Quad removed{quad_at(row, quad, word)};
        for (int k{0}; k < 4; ++k) *sums_at(4 * quad + k, word) += added.differing(k) - removed.differing(k);
      }
    }
  }

  __device__ void add_column(int u, LaneCosts<words>& costs) const {
    const int column{last_column_ - clamped(u, task_.left.width)};
    for (int i{0}; i < words; ++i) {
      const std::uint32_t sums{*sums_at(column, lane_ + i * lanes)};
      costs.even[i] += even_bytes(sums);
      costs.odd[i] += odd_bytes(sums);
    }
  }
  __device__ void remove_column(int u, LaneCosts<words>& costs) const {
    const int column{last_column_ - clamped(u, task_.left.width)};
    for (int i{0}; i < words; ++i) {
      const std::uint32_t sums{*sums_at(column, lane_ + i * lanes)};
      costs.even[i] -= even_bytes(sums);
      costs.odd[i] -= odd_bytes(sums);
    }
  }

  // Columns beyond the image take part, as all lanes of a warp must.
  __device__ void finish_row(int v) const {
    const BestLabel<lanes, words> best_label{hypothesis_.shifts.count, task_.uniqueness_1024};
    const int half{task_.half_window};
    const int begin_u{first_u_ + group_ * group_columns};
    LaneCosts<words> costs{};
    for (int i{-half}; i < half; ++i) add_column(begin_u + i, costs);
    FoundLabel mine{};
    for (int column{0}; column < group_columns; ++column) {
      add_column(begin_u + column + half, costs);
      const FoundLabel found{best_label.find(costs)};
      if (column == lane_) mine = found;
      remove_column(begin_u + column - half, costs);
    }
    const int u{begin_u + lane_};
    if (lane_ < group_columns && u < task_.left.width) hypothesis_.found(u, v) = mine;
  }

  const Correlation& task_;
  const Hypothesis& hypothesis_;
  Room room_;
  std::uint32_t* memory_;
  int first_u_;
  int first_v_;
  int last_column_;
  int lane_;
  int group_;
};

// blockIdx.z: which hypothesis.
template <int lanes, int words>
__global__ void __launch_bounds__(threads) find_best_shifts(Correlation task) {
  auto* const memory = dynamic_shared<std::uint32_t>();
  if (blockIdx.z == 0) {
    Strip<lanes, words>{task, task.upright, memory}.run();
  } else {
    Strip<level_lanes, 1>{task, task.level, memory}.run();
  }
}

// Rows of a block: few enough that all multiprocessors have something to do, and that the block finds room.
int rows_of(const Cuda& cuda, const Correlation& task, int shift_words) {
  constexpr int blocks_wanted{6};  // for each multiprocessor
  constexpr int rows_min{4};
  constexpr int rows_max{32};
  const int row_columns{static_cast<int>(blocks_for(task.left.width, columns)) * task.left.height};
  int rows{row_columns / (blocks_wanted * cuda.multiprocessors())};
  rows = rows < rows_min ? rows_min : (rows > rows_max ? rows_max : rows);
  while (rows > 1 && Room{task.half_window, rows, shift_words}.bytes(shift_words) > shared_max) --rows;
  return rows;
}

template <int lanes, int words>
void correlate_on(Cuda& cuda, Correlation task) {
  constexpr int shift_words{lanes * words > level_lanes ? lanes * words : level_lanes};
  task.rows = rows_of(cuda, task, shift_words);
  const dim3 grid{blocks_for(task.left.width, columns), blocks_for(task.left.height, task.rows), 2};
  launch(cuda, find_best_shifts<lanes, words>, grid, dim3{threads},
         Room{task.half_window, task.rows, shift_words}.bytes(shift_words), task);
}

}  // namespace

void correlate(Cuda& cuda, const DescribedOnDevice& census, const MatchingConfig& config,
               View<FoundLabel, Device> upright, View<FoundLabel, Device> level) {
  const Correlation task{census.left.view(),
                         {census.right.view(), upright_shifts(config), upright},
                         {census.sheared.view(), road_shifts, level},
                         config.window_px / 2,
                         1,
                         uniqueness_1024(config)};
  if (config.disparities <= 64) return correlate_on<16, 1>(cuda, task);
  if (config.disparities <= 128) return correlate_on<32, 1>(cuda, task);
  correlate_on<32, 2>(cuda, task);
}

}  // namespace stereogrid
