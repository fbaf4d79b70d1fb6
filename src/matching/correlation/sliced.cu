// SPDX-License-Identifier: Apache-2.0
//
// Window costs in bit slices, for windows of 9 × 9 pixels and at most 128 disparities. A word holds one bit of 32
// neighbouring columns, a Number is a word for each binary digit, and one logical operation serves 32 columns.
// 1. The census is turned into planes: a word for each of its eight bits.
// 2. A thread has one shift and 32 columns. Row by row it counts the differing bits, adds up nine columns by shifted
// words (24 of the 32 columns have a whole window) and nine rows by adding the new row and subtracting the oldest.
// 3. After some rows a warp decides a row, see sliced_decision.cuh.
#include <algorithm>
#include <utility>

#include "matching/correlation/sliced_decision.cuh"
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"

namespace stereogrid {
namespace {

constexpr int half_window{4};
constexpr int columns{32 - 2 * half_window};  // decided columns of a word
constexpr int guard_words{5};                 // left of the right image: shifts up to 128
constexpr int threads{128};
constexpr int warps{threads / 32};
constexpr int batch{warps};  // rows between two rounds of decisions
constexpr int ring_rows{2 * half_window};
constexpr int level_shifts{8};  // threads for the road's shifts
constexpr int level_bands{4};
constexpr int row_digits{7};  // sum of a row: at most 9 · 8
static_assert(ring_rows % batch == 0 && road_shifts.count <= level_shifts);

struct Hypothesis {
  View<const CensusPlanes, Device> right;
  Shifts shifts;
  View<FoundLabel, Device> found;
};

struct Correlation {
  View<const CensusPlanes, Device> left;
  Hypothesis upright;
  Hypothesis level;
  int upright_blocks;  // the first of a row of blocks
  int rows;            // rows of a block
  int uniqueness_1024;
};

struct Shared {
  Word ring[ring_rows][row_digits][threads];  // sums of the last rows
  Word costs[batch][cost_digits][threads];
};
static_assert(sizeof(Shared) <= 48 << 10);

// Windows' sums over one row: of the differing bits of a word of columns at one shift.
class RowSums {
 public:
  __device__ RowSums(const Correlation& task, const Hypothesis& hypothesis, int word, int shift)
      : left_{task.left}, right_{hypothesis.right}, word_{word} {
    const int first_u{columns * word - half_window};
    const int at{first_u - shift + 32 * guard_words};
    right_word_ = at / 32;
    right_bit_ = static_cast<unsigned>(at % 32);
    before_ = word == 0 ? (1u << half_window) - 1 : 0u;
    last_ = hypothesis.found.width - 1 - first_u;
    behind_ = last_ < 31 ? ~0u << (last_ + 1) : 0u;
  }

  // Rows and columns outside the image repeat the border.
  __device__ Number<row_digits> operator()(int row) const {
    const int v{clamped(row, left_.height)};
    const CensusPlanes left{left_(word_, v)};
    const CensusPlanes right{right_(right_word_, v)};
    const CensusPlanes next{right_(right_word_ + 1, v)};
    Word differing[8];
    STEREOGRID_UNROLL
    for (int k = 0; k < 8; ++k) {
      differing[k] = left.bits[k] ^ __funnelshift_r(right.bits[k], next.bits[k], right_bit_);
    }
    Number<4> one{ones_of(differing)};
    if ((before_ | behind_) != 0) {
      STEREOGRID_UNROLL
      for (int i = 0; i < 4; ++i) {
        const Word x{one.digits[i]};
        one.digits[i] = (x & ~(before_ | behind_)) | ((0u - (x >> half_window & 1u)) & before_) |
                        ((0u - (x >> (last_ & 31) & 1u)) & behind_);
      }
    }
    const auto two = sum(one, one >> 1);
    const auto four = sum(two, two >> 2);
    const auto eight = sum(four, four >> 4);
    return resized<row_digits>(sum(eight, one >> 8));
  }

 private:
  View<const CensusPlanes, Device> left_;
  View<const CensusPlanes, Device> right_;
  int word_;
  int right_word_;
  unsigned right_bit_;
  Word before_;  // columns before the image, and those behind it
  Word behind_;
  int last_;  // the image's last column
};

// Groups of `shifts` threads have a word of columns and, the road's, one of some bands of rows: with few shifts more of
// the time goes into decisions, and all blocks should take equally long.
template <int shifts>
struct Groups {
  static constexpr int count{threads / shifts};
  static constexpr int bands{shifts == level_shifts ? level_bands : 1};
  static constexpr int words{count / bands};
};

template <int shifts>
__device__ void correlate_words(const Correlation& task, const Hypothesis& hypothesis, int block) {
  using Of = Groups<shifts>;
  Shared& shared{*dynamic_shared<Shared>()};
  const View<FoundLabel, Device>& found{hypothesis.found};
  const int rows{task.rows / Of::bands};
  const int thread{static_cast<int>(threadIdx.x)};
  const auto word_of = [&](int group) { return block * Of::words + group % Of::words; };
  const auto first_v_of = [&](int group) {
    return static_cast<int>(blockIdx.y) * task.rows + group / Of::words * rows;
  };
  const int first_v{first_v_of(thread / shifts)};
  const RowSums row_sums{task, hypothesis, min(word_of(thread / shifts), task.left.width - 1),
                         hypothesis.shifts.first + thread % shifts};
  Number<cost_digits> cost{};
  for (int i{0}; i < ring_rows; ++i) {
    const auto row = row_sums(first_v - half_window + i);
    cost = resized<cost_digits>(sum(cost, row));
    store<threads>(row, &shared.ring[i][0][thread]);
  }
  for (int begin{0}; begin < rows; begin += batch) {
    for (int i{0}; i < batch; ++i) {
      const auto row = row_sums(first_v + begin + i + half_window);
      cost = resized<cost_digits>(sum(cost, row));
      store<threads>(cost, &shared.costs[i][0][thread]);
      Word* const slot{&shared.ring[(begin + i) % ring_rows][0][thread]};
      cost = resized<cost_digits>(difference(cost, load<row_digits, threads>(slot)));
      store<threads>(row, slot);
    }
    __syncthreads();
    for (int i{thread / 32}; i < Of::count * batch; i += warps) {
      const int group{i / batch};
      const int row{i % batch};
      const int u{word_of(group) * columns + thread % 32};
      const int v{first_v_of(group) + begin + row};
      const Decision<shifts, threads> decision{&shared.costs[row][0][group * shifts], hypothesis.shifts.count};
      const FoundLabel label{decision.find(task.uniqueness_1024)};
      if (thread % 32 < columns && u < found.width && v < found.height) found(u, v) = label;
    }
    __syncthreads();
  }
}

template <int shifts>
__global__ void __launch_bounds__(threads) find_best_of_slices(Correlation task) {
  const int block{static_cast<int>(blockIdx.x)};
  if (block < task.upright_blocks) {
    correlate_words<shifts>(task, task.upright, block);
  } else {
    correlate_words<level_shifts>(task, task.level, block - task.upright_blocks);
  }
}

// blockIdx.z: which of the three images. A warp has a word of some rows, a lane a column; outside the image the border
// is repeated.
__global__ void __launch_bounds__(threads)
    slice(View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
          View<const std::uint8_t, Device> sheared, View<CensusPlanes, Device> left_planes,
          View<CensusPlanes, Device> right_planes, View<CensusPlanes, Device> sheared_planes) {
  const int image{static_cast<int>(blockIdx.z)};
  const View<const std::uint8_t, Device> census{image == 0 ? left : (image == 1 ? right : sheared)};
  const View<CensusPlanes, Device> planes{image == 0 ? left_planes : (image == 1 ? right_planes : sheared_planes)};
  const int word{static_cast<int>(blockIdx.x) * warps + static_cast<int>(threadIdx.x) / 32};
  if (word >= planes.width) return;
  const int lane{static_cast<int>(threadIdx.x) % 32};
  const int u{clamped(lane + (image == 0 ? columns * word - half_window : 32 * (word - guard_words)), census.width)};
  for (int v{static_cast<int>(blockIdx.y)}; v < census.height; v += static_cast<int>(gridDim.y)) {
    const Word bits{census(u, v)};
    Word mine{0};
    STEREOGRID_UNROLL
    for (int k = 0; k < short_census_bits; ++k) {
      const Word plane{__ballot_sync(all_lanes, static_cast<int>(bits & 1u << k))};
      mine = k == lane ? plane : mine;
    }
    if (lane < short_census_bits) planes(word, v).bits[lane] = mine;
  }
}

// Rows of a block: as few as let all blocks run at once, within limits, as each block computes eight rows more.
int rows_of(const Cuda& cuda, unsigned blocks_of_row, int height) {
  constexpr unsigned resident_blocks{4};  // for each multiprocessor, by shared memory of 200 KB
  constexpr int step{level_bands * batch};
  constexpr int rows_max{4 * step};
  int rows{step};
  while (rows < rows_max &&
         blocks_of_row * blocks_for(height, rows) > resident_blocks * static_cast<unsigned>(cuda.multiprocessors())) {
    rows += step;
  }
  return rows;
}

template <int shifts>
void find_best(Cuda& cuda, Correlation task) {
  const int words{task.left.width};
  const int height{task.left.height};
  task.upright_blocks = static_cast<int>(blocks_for(words, Groups<shifts>::words));
  const unsigned blocks{blocks_for(words, Groups<shifts>::words) + blocks_for(words, Groups<level_shifts>::words)};
  task.rows = rows_of(cuda, blocks, height);
  launch(cuda, find_best_of_slices<shifts>, dim3{blocks, blocks_for(height, task.rows)}, dim3{threads}, sizeof(Shared),
         task);
}

}  // namespace

SlicedCensus::SlicedCensus(int width, int height)
    : left{static_cast<int>(blocks_for(width, columns)), height},
      right{static_cast<int>(blocks_for(width + road_margin_px, 32)) + guard_words + 1, height},
      sheared{right.width(), height} {}

bool has_slices(const MatchingConfig& config) {
  return config.window_px == 2 * half_window + 1 && config.disparities <= 128;
}

void correlate(Cuda& cuda, const DescribedOnDevice& census, SlicedCensus& slices, const MatchingConfig& config,
               View<FoundLabel, Device> upright, View<FoundLabel, Device> level) {
  launch(cuda, slice,
         dim3{blocks_for(std::max(slices.left.width(), slices.right.width()), warps), blocks_for(upright.height, 8), 3},
         dim3{threads}, 0, census.left.view(), census.right.view(), census.sheared.view(), slices.left.view(),
         slices.right.view(), slices.sheared.view());
  const Correlation task{std::as_const(slices.left).view(),
                         {std::as_const(slices.right).view(), upright_shifts(config), upright},
                         {std::as_const(slices.sheared).view(), road_shifts, level},
                         0,
                         0,
                         uniqueness_1024(config)};
  if (config.disparities <= 64) return find_best<64>(cuda, task);
  find_best<128>(cuda, task);
}

}  // namespace stereogrid
