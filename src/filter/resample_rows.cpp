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
  RowResampler(const Resampling& resampling, UnseenCells unseen)
      : resampling_{resampling},
        layout_{resampling.world.geometry.nx},
        unseen_{unseen},
        has_blocks_{unseen.blocks != nullptr && !unseen.blocks->empty()} {}

  void run(int iy) const {
    const int columns{resampling_.cells.grid.nx};
    const int parts{resampled_parts(columns)};
    for (int part{0}; part < parts; ++part) {
      const int begin{part * resampled_columns};
      const int end{std::min(begin + resampled_columns, columns)};
      const bool is_unseen{has_blocks_ && are_unseen(place_of(begin, iy), place_of(end - 1, iy))};
      std::uint8_t was_unseen{0};
      if (unseen_.parts != nullptr) {
        const auto i = static_cast<std::size_t>(iy) * static_cast<std::size_t>(parts) + static_cast<std::size_t>(part);
        was_unseen = std::exchange((*unseen_.parts)[i], is_unseen ? std::uint8_t{1} : std::uint8_t{0});
      }
      if (is_unseen && was_unseen != 0) continue;
      resample_cells(resampling_, begin, is_unseen ? begin + 1 : end, iy);
      if (is_unseen) repeat(begin, end, iy);
    }
  }

 private:
  // Of a cell's centre, in cells of the window.
  [[nodiscard]] Point2 place_of(int ix, int iy) const {
    const GridGeometry& window{resampling_.world.geometry};
    const Point2 at{resampling_.cells.centre(ix, iy)};
    return {(at.x - window.x_min_m) / window.cell_size_m, (at.y - window.y_min_m) / window.cell_size_m};
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

  // Between two places and around them the window has unseen cells only.
  [[nodiscard]] bool are_unseen(Point2 first, Point2 last) const {
    const CellBox cells{floor_of(std::min(first.x, last.x)) - 1, floor_of(std::min(first.y, last.y)) - 1,
                        floor_of(std::max(first.x, last.x)) + 1, floor_of(std::max(first.y, last.y)) + 1};
    if (cells.x_first < 0 || cells.y_first < 0 || cells.x_last >= layout_.cells || cells.y_last >= layout_.cells) {
      return false;
    }
    for (int y{cells.y_first / block_rows}; y <= cells.y_last / block_rows; ++y) {
      for (int x{cells.x_first / block_columns}; x <= cells.x_last / block_columns; ++x) {
        if ((*unseen_.blocks)[static_cast<std::size_t>(y * layout_.across + x)] == 0) return false;
      }
    }
    return true;
  }

  const Resampling& resampling_;
  BlockLayout layout_;
  UnseenCells unseen_;
  bool has_blocks_;
};

}  // namespace

void resample_rows(const Pose2& world_from_vehicle, int begin, int end, UnseenCells unseen, FrameResult& result) {
  const Resampling resampling{grid_in_vehicle(result.vehicle.geometry, world_from_vehicle), result.world,
                              result.vehicle};
  const RowResampler rows{resampling, unseen};
  for (int iy{begin}; iy < end; ++iy) rows.run(iy);
}

}  // namespace stereogrid
