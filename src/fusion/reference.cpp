// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include "fusion/fusion.hpp"
#include "fusion/model.hpp"

namespace stereogrid {
namespace {

OtherCells cells_of(const ObservedGrid& grid) {
  return {grid.geometry, grid.occupancy.data(), grid.confidence.empty() ? nullptr : grid.confidence.data()};
}

}  // namespace

double claimed(std::span<const ObservedGrid> others, Point2 at) {
  IndependentPool pool;
  for (const ObservedGrid& other : others) add(cells_of(other), at, pool);
  return pool.probability();
}

void fuse_rows(std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
               View<float> cells, int begin, int end) {
  for (int iy{begin}; iy < end; ++iy) {
    for (int ix{0}; ix < cells.width; ++ix) {
      IndependentPool pool;
      pool.add(static_cast<double>(cells(ix, iy)), config.stereo_confidence);
      for (const ObservedGrid& other : others) {
        add(cells_of(other), grid.centre(ix, iy), pool);
      }
      cells(ix, iy) = static_cast<float>(pool.probability());
    }
  }
}

void fuse_camera_rows(std::span<const View<const float>> cameras, int begin, int end, View<float> cells) {
  for (int y{begin}; y < end; ++y) {
    for (int x{0}; x < cells.width; ++x) {
      CameraPool pool;
      for (const View<const float>& camera : cameras) pool.add(camera(x, y));
      cells(x, y) = pool.probability();
    }
  }
}

void fuse(Reference&, std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
          View<float> cells) {
  if (others.empty()) return;
  fuse_rows(others, grid, config, cells, 0, cells.height);
}

}  // namespace stereogrid
