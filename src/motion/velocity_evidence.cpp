// SPDX-License-Identifier: Apache-2.0
#include "motion/velocity_evidence.hpp"

#include <cmath>
#include <utility>

#include "clamped_to_int.hpp"

namespace stereogrid {
namespace {

/// Standard deviation of an object's extent around a point, m.
constexpr double extent_m{0.35};
/// In standard deviations, where a point's weight, 1 at its place, has fallen to 0.
constexpr double reach{2};
/// Maximum squared Mahalanobis distances of velocities and of places that agree. Places differ within an object.
constexpr double velocities_agree{5};
constexpr double places_agree{4};
constexpr double object_m{1};
/// Maximum distance along an axis of points that are compared.
constexpr double compared_m{4};
/// The same positions enter the velocities of several frames.
constexpr double share_of_information{0.5};
/// Maximum information of a cell, in points, as their errors are correlated.
constexpr double points_max{4};
/// Least likelihood of standstill that evidence of it has: 2.3 standard deviations.
constexpr float standstill_min{0.04f};
/// Likelihood of standstill below which evidence starts motion, and the least number of its points.
constexpr float started_max{0.03f};
constexpr int started_points{2};
/// Points that agree with such a point, and it.
constexpr int supported_points{4};
/// Share from which on a view counts as repeated.
constexpr double repeated_min{0.8};

double variance_at(const std::vector<double>& axis_mps, double v_mps) {
  return lattice_variance(step_at(axis_mps.data(), static_cast<int>(axis_mps.size()), v_mps));
}

InformationSum own_velocity(const FlowVector& vector) {
  return {inverted(vector.velocity_covariance), vector.velocity};
}

bool agree(const FlowVector& a, const FlowVector& b) {
  const Point2 apart{b.place.x - a.place.x, b.place.y - a.place.y};
  if (std::abs(apart.x) > compared_m || std::abs(apart.y) > compared_m) return false;
  const Symmetric2 places{widened(a.place_covariance + b.place_covariance, object_m * object_m)};
  if (squared(inverted(places), apart) > places_agree) return false;
  const Point2 difference{b.velocity.x - a.velocity.x, b.velocity.y - a.velocity.y};
  return squared(inverted(a.velocity_covariance + b.velocity_covariance), difference) <= velocities_agree;
}

}  // namespace

EvidenceMap::EvidenceMap(int cells, std::vector<double> axis_mps, std::size_t points)
    : sums_{cells, cells},
      axis_mps_{std::move(axis_mps)},
      touched_(sums_.size()),
      rows_(static_cast<std::size_t>(cells)) {
  evidence_.reserve(sums_.size());
  averages_.reserve(points);
  points_.reserve(points);
}

// Cells within `half` of `at`.
EvidenceMap::CellRange EvidenceMap::cells_around(double at, double half, double min, double cell_size_m, int count) {
  return {std::max(clamped_to_int(std::floor((at - half - min) / cell_size_m)), 0),
          std::min(clamped_to_int(std::floor((at + half - min) / cell_size_m)), count - 1)};
}

// Errors of neighbours average out, and a wrong match stays without support.
void EvidenceMap::average(const std::vector<FlowVector>& vectors) {
  averages_.clear();
  for (const FlowVector& vector : vectors) averages_.push_back({own_velocity(vector)});
  for (std::size_t i{0}; i < vectors.size(); ++i) {
    for (std::size_t j{i + 1}; j < vectors.size(); ++j) {
      if (!agree(vectors[i], vectors[j])) continue;
      averages_[i].add(averages_[j].own);
      averages_[j].add(averages_[i].own);
    }
  }
}

void EvidenceMap::take(const std::vector<FlowVector>& vectors, const GridGeometry& window) {
  window_ = window;
  average(vectors);
  points_.clear();
  for (const FlowVector& vector : vectors) {
    const Average& average{averages_[points_.size()]};
    const Symmetric2 around{widened(vector.place_covariance, extent_m * extent_m)};
    points_.push_back(
        {vector.place,
         inverted(around),
         {average.information(), average.velocity.mean()},
         average.independent(),
         average.points >= supported_points ? 1 : 0,
         cells_around(vector.place.x, reach * std::sqrt(around.xx), window.x_min_m, window.cell_size_m, window.nx),
         cells_around(vector.place.y, reach * std::sqrt(around.yy), window.y_min_m, window.cell_size_m, window.ny)});
  }
}

// Each row by itself: a cell's points come in their order, however the rows are divided.
void EvidenceMap::spread(int begin_row, int end_row) {
  for (int row{begin_row}; row < end_row; ++row) rows_[static_cast<std::size_t>(row)].touched = 0;
  for (const Point& point : points_) {
    const int end{std::min(point.rows.last + 1, end_row)};
    for (int row{std::max(point.rows.first, begin_row)}; row < end; ++row) spread(point, row);
  }
}

void EvidenceMap::spread(const Point& point, int row) {
  Sum* const sums{sums_.row(row)};
  const int first_cell{row * window_.nx};
  int* const touched{touched_.data() + first_cell};
  int& count{rows_[static_cast<std::size_t>(row)].touched};
  for (int column{point.columns.first}; column <= point.columns.last; ++column) {
    const Point2 centre{window_.centre(column, row)};
    const Point2 away{centre.x - point.place.x, centre.y - point.place.y};
    const double weight{1 - squared(point.distance, away) / (reach * reach)};
    if (weight <= 0) continue;
    Sum& sum{sums[column]};
    if (sum.weight == 0) touched[count++] = first_cell + column;
    sum.weight += weight;
    sum.points += weight * point.independent;
    sum.supported += point.supported;
    sum.velocity.add(point.measured, weight);
  }
}

void EvidenceMap::make_room() {
  int count{0};
  for (Row& row : rows_) {
    row.evidence = count;
    count += row.touched;
  }
  evidence_.resize(static_cast<std::size_t>(count));
}

void EvidenceMap::conclude(int begin_row, int end_row) {
  for (int row{begin_row}; row < end_row; ++row) {
    const Row& of{rows_[static_cast<std::size_t>(row)]};
    int* const touched{touched_.data() + row * window_.nx};
    std::sort(touched, touched + of.touched);
    for (int i{0}; i < of.touched; ++i) {
      Sum& sum{sums_.data()[touched[i]]};
      evidence_[static_cast<std::size_t>(of.evidence + i)] = evidence_of(touched[i], sum);
      sum = {};
    }
  }
}

VelocityEvidence EvidenceMap::evidence_of(int cell, const Sum& sum) const {
  const Point2 velocity{sum.velocity.mean()};
  // a cell whose points contradict each other is at an edge between two things
  const double contradiction{sum.velocity.misfit() / sum.weight};
  const double share{share_of_information / (1 + contradiction) * std::min(1.0, points_max / sum.points)};
  // a precise measurement between two velocities of the lattice would contradict both
  const Symmetric2 covariance{1 / share * inverted(sum.velocity.information)};
  const Symmetric2 information{inverted({covariance.xx + variance_at(axis_mps_, velocity.x), covariance.xy,
                                         covariance.yy + variance_at(axis_mps_, velocity.y)})};
  const double fastest_mps{axis_mps_.back()};
  const auto limited = [&](double v_mps) { return static_cast<float>(std::clamp(v_mps, -fastest_mps, fastest_mps)); };
  VelocityEvidence evidence{cell,
                            limited(velocity.x),
                            limited(velocity.y),
                            static_cast<float>(information.xx),
                            static_cast<float>(information.xy),
                            static_cast<float>(information.yy)};
  const float standstill{likelihood_of(evidence, 0.0f, 0.0f)};
  evidence.is_static = standstill > standstill_min ? 1 : 0;
  const Point2 centre{window_.centre(cell % window_.nx, cell / window_.nx)};
  evidence.is_repeated = evidence.is_static != 0 && view_.repeated(centre) >= repeated_min ? 1 : 0;
  const bool can_move{axis_mps_.size() > 1};
  evidence.starts_motion = can_move && standstill < started_max && sum.supported >= started_points ? 1 : 0;
  return evidence;
}

}  // namespace stereogrid
