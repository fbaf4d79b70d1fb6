// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "filter/filter.hpp"
#include "filter/resampling/resample_simd.hpp"

namespace stereogrid {
namespace {

// Rows of the vehicle's layers, part by part.
class RowResampler {
 public:
  RowResampler(const Resampling& resampling, KnownKinds kinds)
      : resampling_{resampling},
        layout_{resampling.world.geometry.nx},
        kinds_{kinds},
        has_blocks_{kinds.blocks != nullptr && !kinds.blocks->empty()} {}

  void run(int iy) const {
    const int columns{resampling_.cells.grid.nx};
    const int parts{resampled_parts(columns)};
    for (int part{0}; part < parts; ++part) {
      const int begin{part * resampled_columns};
      const int end{std::min(begin + resampled_columns, columns)};
      const BlockKind kind{has_blocks_ ? kind_around(begin, end - 1, iy) : BlockKind::any};
      BlockKind before{BlockKind::any};
      if (kinds_.parts != nullptr) {
        const auto i = static_cast<std::size_t>(iy) * static_cast<std::size_t>(parts) + static_cast<std::size_t>(part);
        before = std::exchange((*kinds_.parts)[i], kind);
      }
      run(begin, end, iy, kind, before);
    }
  }

 private:
  void run(int begin, int end, int iy, BlockKind kind, BlockKind before) const {
    const bool is_unseen{kind == BlockKind::unseen};
    if (kind == BlockKind::any) return resample_cells(resampling_, begin, end, iy);
    if (is_unseen && before == BlockKind::unseen) return;
    resample_even_cells(resampling_, begin, is_unseen ? begin + 1 : end, iy, !is_unseen && before != BlockKind::any);
    if (is_unseen) repeat(begin, end, iy);
  }

  // Cells ix + 1 … end − 1 of row iy as cell ix.
  void repeat(int ix, int end, int iy) const {
    GridLayers& to{resampling_.vehicle};
    for (Image<float>* layer : {&to.occupancy, &to.velocity_x, &to.velocity_y, &to.age_s, &to.velocity_xx,
                                &to.velocity_xy, &to.velocity_yy, &to.moving}) {
      float* const row{layer->row(iy)};
      std::fill(row + ix + 1, row + end, row[ix]);
    }
  }

  // Common kind of all blocks of the window around cells first to last of row iy.
  [[nodiscard]] BlockKind kind_around(int first, int last, int iy) const {
    const CellPlaces& places{resampling_.places};
    const float x[]{places.x_of(first, iy), places.x_of(last, iy)};
    const float y[]{places.y_of(first, iy), places.y_of(last, iy)};
    const float low_x{std::min(x[0], x[1]) - 1};
    const float low_y{std::min(y[0], y[1]) - 1};
    const float high_x{std::max(x[0], x[1]) + 1};
    const float high_y{std::max(y[0], y[1]) + 1};
    const auto size = static_cast<float>(layout_.cells);
    if (!(low_x >= 0 && low_y >= 0 && high_x < size && high_y < size)) return BlockKind::any;
    const CellBox cells{static_cast<int>(low_x), static_cast<int>(low_y), static_cast<int>(high_x),
                        static_cast<int>(high_y)};
    BlockKind least{BlockKind::unseen};
    for (int row{cells.y_first / block_rows}; row <= cells.y_last / block_rows; ++row) {
      for (int i{cells.x_first / block_columns}; i <= cells.x_last / block_columns; ++i) {
        least = std::min(least, (*kinds_.blocks)[static_cast<std::size_t>(row * layout_.across + i)]);
      }
    }
    return least;
  }

  const Resampling& resampling_;
  BlockLayout layout_;
  KnownKinds kinds_;
  bool has_blocks_;
};

}  // namespace

void resample_rows(const Pose2& world_from_vehicle, int begin, int end, KnownKinds kinds, FrameResult& result) {
  const GridInVehicle cells{grid_in_vehicle(result.vehicle.geometry, world_from_vehicle)};
  const Resampling resampling{cells, places_in_window(cells, result.world.geometry), result.world, result.vehicle};
  const RowResampler rows{resampling, kinds};
  for (int iy{begin}; iy < end; ++iy) rows.run(iy);
}

}  // namespace stereogrid
