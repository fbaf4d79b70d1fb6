// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "motion/velocity_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "clamped_to_int.hpp"

namespace stereogrid {
namespace {

/// Standard deviation of how far from a point its thing goes on, m.
constexpr double extent_m{0.35};
/// In standard deviations, where a point's weight, 1 at its place, has fallen to 0.
constexpr double reach{2};
/// The same positions enter the velocities of several frames.
constexpr double share_of_information{0.5};
/// So many points' information counts at most: what they err by together, they err by all.
constexpr double weight_max{4};

// Cells from min to max along an axis that lie within `half` of `at`.
struct CellRange {
  CellRange(double at, double half, double min, double cell_size_m, int count)
      : first{std::max(clamped_to_int(std::floor((at - half - min) / cell_size_m)), 0)},
        last{std::min(clamped_to_int(std::floor((at + half - min) / cell_size_m)), count - 1)} {}

  int first;
  int last;
};

}  // namespace

void EvidenceMap::spread(const FlowVector& vector, const GridGeometry& window) {
  const Symmetric2 around{widened(vector.place_covariance, extent_m * extent_m)};
  const Symmetric2 distance{inverted(around)};
  const InformationSum measured{inverted(vector.velocity_covariance), vector.velocity};
  const CellRange rows{vector.place.y, reach * std::sqrt(around.yy), window.y_min_m, window.cell_size_m, window.ny};
  const CellRange columns{vector.place.x, reach * std::sqrt(around.xx), window.x_min_m, window.cell_size_m, window.nx};
  for (int iy{rows.first}; iy <= rows.last; ++iy) {
    for (int ix{columns.first}; ix <= columns.last; ++ix) {
      const Point2 centre{window.centre(ix, iy)};
      const Point2 away{centre.x - vector.place.x, centre.y - vector.place.y};
      const double weight{1 - squared(distance, away) / (reach * reach)};
      if (weight <= 0) continue;
      Sum& sum{sums_(ix, iy)};
      if (sum.weight == 0) touched_.push_back(iy * window.nx + ix);
      sum.weight += weight;
      sum.velocity.add(measured, weight);
    }
  }
}

VelocityEvidence EvidenceMap::evidence_of(int cell, const Sum& sum) const {
  const Point2 velocity{sum.velocity.mean()};
  // a cell whose points contradict each other is at an edge between two things
  const double contradiction{sum.velocity.misfit() / sum.weight};
  const double share{share_of_information / (1 + contradiction) * std::min(1.0, weight_max / sum.weight)};
  const Symmetric2 information{share * sum.velocity.information};
  const auto limited = [&](double v_mps) { return static_cast<float>(std::clamp(v_mps, -fastest_mps_, fastest_mps_)); };
  return {cell,
          limited(velocity.x),
          limited(velocity.y),
          static_cast<float>(information.xx),
          static_cast<float>(information.xy),
          static_cast<float>(information.yy)};
}

const std::vector<VelocityEvidence>& EvidenceMap::gather(const std::vector<FlowVector>& vectors,
                                                         const GridGeometry& window) {
  evidence_.clear();
  touched_.clear();
  for (const FlowVector& vector : vectors) spread(vector, window);
  std::sort(touched_.begin(), touched_.end());
  for (const int cell : touched_) {
    Sum& sum{sums_.data()[cell]};
    evidence_.push_back(evidence_of(cell, sum));
    sum = {};
  }
  return evidence_;
}

}  // namespace stereogrid
