// SPDX-License-Identifier: Apache-2.0
//
// Uses every host-and-device function of src/*/model.hpp in a kernel. There is nothing to run: this file guards that
// the formulas of the CPU compile for the GPU as they stand.
#include <cstdint>

#include "filter/model.hpp"
#include "fusion/model.hpp"
#include "geometry/road_plane.hpp"
#include "images/row_alignment/model.hpp"
#include "matching/model.hpp"
#include "observation/projection/model.hpp"
#include "observation/u_disparity/model.hpp"

namespace stereogrid {
namespace {

struct GreyAt {
  const std::uint8_t* centre;
  int pitch;
  STEREOGRID_HD int operator()(int i, int j) const { return centre[j * pitch + i]; }
};

__global__ void matching_models(const std::uint8_t* image, int width, RoadPlane plane, float* out) {
  const int u{static_cast<int>(threadIdx.x)};
  const RoadRow road{road_row(plane, 0)};
  const Candidate candidate{1, 2, 3, 4, 5};
  const Winner winner{
      winner_of(candidate, candidate, road.at(u), highest_rival(compared_bits(13), 20), true, ConfidenceModel{})};
  out[u] = short_census(GreyAt{image + u, width}) + sheared(image, width, u, road) + winner.disparity +
           single_numbers::confidence_of(winner.evidence);
}

__global__ void alignment_models(const std::uint8_t* image, int width, float* out) {
  const unsigned u{threadIdx.x};
  out[u] = between_rows(image[u], image[u + width], 77);
}

__global__ void u_disparity_models(const float* disparity, float* out) {
  const unsigned i{threadIdx.x};
  const int bin{bin_of(disparity[i])};
  const float visible{visibility_of(bin, 9)};
  const float obstacle{obstacle_probability(visible, 0.5f, bin_constants(0.02f, 0.02f))};
  out[pair_index(bin, 0)] = occupancy_probability(obstacle, 0.1f, bin_constants(0.02f, 0.02f));
}

__global__ void projection_models(Rig rig, GridInVehicle grid, int u, int d, double* out) {
  const BinGeometry bins{rig};
  const CellCorners cell{grid.corners(static_cast<int>(threadIdx.x), static_cast<int>(threadIdx.y))};
  const ColumnSpan span{columns_of(bins, cell, bins.nearest_x(d), bins.farthest_x(d))};
  const Point2 centre{grid.centre(static_cast<int>(threadIdx.x), static_cast<int>(threadIdx.y))};
  const bool speaks{span.touches(u) || bins.disparity(centre.x) > d};
  out[threadIdx.x] = speaks ? cell.nearest_x() : cell.farthest_x();
}

__global__ void fusion_models(double* p) {
  IndependentPool pool;
  pool.add(p[threadIdx.x], 1);
  p[threadIdx.x] = pool.probability();
}

__global__ void filter_models(FilterStep step, double shift, const float* table, float* out) {
  const int k{static_cast<int>(threadIdx.x)};
  const Antecedents from{antecedents(shift, -shift, 1, 0)};
  const Likelihood likelihood{likelihood_of(table, prior_of(step, k))};
  const float moving{disturbed(step.kept_moving, out[k], gained_by_moving(step, 1.0f, out[0]))};
  VelocitySums sums;
  sums.add(2, {between(moving, disturbed_standing(step, 1.0f, out[0]), from.fx), 0, 1});
  const JointUpdate update{
      joint_update(step, sums.mass, 0.0f, shift > 0 ? 1.0f : 0.0f, likelihood, view_of(step, k, k))};
  const VelocityEstimate velocity{estimate_of(updated(step, update, sums))};
  const TayUpdate<float> tay{tay_update(1.0f, still_occupied(step, 0.5f), likelihood.occupied, likelihood.empty)};
  out[k] = velocity.xx + moving_share(update.occupancy, tay.occupied) + tay.all + floor_of(shift);
}

}  // namespace

/// Keeps the kernels: unused ones are dropped before they are compiled for the device.
void launch_all(const std::uint8_t* image, float* floats, double* doubles) {
  alignment_models<<<1, 32>>>(image, 32, floats);
  matching_models<<<1, 32>>>(image, 32, RoadPlane{}, floats);
  u_disparity_models<<<1, 32>>>(floats, floats);
  projection_models<<<1, 32>>>(Rig{}, GridInVehicle{}, 1, 1, doubles);
  fusion_models<<<1, 32>>>(doubles);
  filter_models<<<1, 32>>>(FilterStep{}, 0.5, floats, floats);
}

}  // namespace stereogrid
