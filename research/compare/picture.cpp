// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.hpp"

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "pictures/drawing.hpp"

namespace stereogrid::research {
namespace {

constexpr int columns{5};
constexpr int tile_px{300};
constexpr int title_px{22};
constexpr int gap_px{10};

cv::Vec3b colour_of(const evaluation::Labels& labels, int ix, int iy) {
  if (labels.cells(ix, iy) == evaluation::not_scored) return {170, 170, 170};
  if (labels.cells(ix, iy) == evaluation::labelled_free) return {255, 255, 255};
  return labels.partly_hidden(ix, iy) != 0 ? cv::Vec3b{230, 40, 40} : cv::Vec3b{0, 0, 0};
}

/// From above, ahead is up.
template <class ColourOf>
cv::Mat draw_cells(const GridGeometry& grid, const ColourOf& colour) {
  cv::Mat cells(grid.nx, grid.ny, CV_8UC3);
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) cells.at<cv::Vec3b>(grid.nx - 1 - ix, grid.ny - 1 - iy) = colour(ix, iy);
  }
  return cells;
}

class Sheet {
 public:
  Sheet(const Image<std::uint8_t>& left, const GridGeometry& grid, std::size_t tiles)
      : tile_height_px_{std::max(1, tile_px * grid.nx / grid.ny)},
        camera_height_px_{std::max(1, width_px * left.height() / left.width())},
        canvas_(camera_height_px_ + gap_px + rows_for(tiles) * (tile_height_px_ + title_px + gap_px), width_px, CV_8UC3,
                cv::Scalar{250, 250, 248}) {
    cv::Mat grey(left.height(), left.width(), CV_8UC1);
    std::memcpy(grey.data, left.data(), left.size());
    cv::Mat colour;
    cv::cvtColor(grey, colour, cv::COLOR_GRAY2RGB);
    cv::Mat part{canvas_(cv::Rect{0, 0, width_px, camera_height_px_})};
    cv::resize(colour, part, part.size(), 0, 0, cv::INTER_LINEAR);
  }

  void add(const std::string& title, const cv::Mat& cells) {
    const int x{(tiles_ % columns) * (tile_px + gap_px)};
    const int y{camera_height_px_ + gap_px + tiles_ / columns * (tile_height_px_ + title_px + gap_px)};
    ++tiles_;
    app::draw_text(canvas_, x, y + title_px - 7, title, app::palette::ink, app::Align::left, 0.4);
    const app::Box box{x, y + title_px, tile_px, tile_height_px_};
    cv::Mat part{canvas_(cv::Rect{box.x, box.y, box.width, box.height})};
    cv::resize(cells, part, part.size(), 0, 0, cv::INTER_NEAREST);
    app::frame_box(canvas_, box);
  }

  [[nodiscard]] io::RgbImage image() const {
    io::RgbImage image{canvas_.cols, canvas_.rows, Image<std::uint8_t>{3 * canvas_.cols, canvas_.rows}};
    std::memcpy(image.pixels.data(), canvas_.data, image.pixels.size());
    return image;
  }

 private:
  static constexpr int width_px{columns * (tile_px + gap_px)};
  static int rows_for(std::size_t tiles) { return (static_cast<int>(tiles) + columns - 1) / columns; }

  int tile_height_px_;
  int camera_height_px_;
  cv::Mat canvas_;
  int tiles_{0};
};

}  // namespace

io::RgbImage draw_comparison(const Image<std::uint8_t>& left, const evaluation::Labels& labels,
                             const std::vector<NamedGrid>& grids) {
  Sheet sheet{left, labels.geometry, grids.size() + 1};
  sheet.add("truth", draw_cells(labels.geometry, [&](int ix, int iy) { return colour_of(labels, ix, iy); }));
  for (const NamedGrid& grid : grids) {
    sheet.add(grid.title, draw_cells(labels.geometry, [&](int ix, int iy) {
                const std::uint8_t grey{app::grey_of(grid.occupancy(ix, iy))};
                return cv::Vec3b{grey, grey, grey};
              }));
  }
  return sheet.image();
}

}  // namespace stereogrid::research
