// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "filter/filter.hpp"
#include "filter/resample_simd.hpp"

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

  // What holds for all blocks of the window between cells first and last of row iy and around them.
  [[nodiscard]] BlockKind kind_around(int first, int last, int iy) const {
    const CellPlaces& places{resampling_.places};
    const Point2 from{places.x_of(first, iy), places.y_of(first, iy)};
    const Point2 to{places.x_of(last, iy), places.y_of(last, iy)};
    const CellBox cells{floor_of(std::min(from.x, to.x)) - 1, floor_of(std::min(from.y, to.y)) - 1,
                        floor_of(std::max(from.x, to.x)) + 1, floor_of(std::max(from.y, to.y)) + 1};
    if (cells.x_first < 0 || cells.y_first < 0 || cells.x_last >= layout_.cells || cells.y_last >= layout_.cells) {
      return BlockKind::any;
    }
    BlockKind least{BlockKind::unseen};
    for (int y{cells.y_first / block_rows}; y <= cells.y_last / block_rows; ++y) {
      for (int x{cells.x_first / block_columns}; x <= cells.x_last / block_columns; ++x) {
        least = std::min(least, (*kinds_.blocks)[static_cast<std::size_t>(y * layout_.across + x)]);
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
