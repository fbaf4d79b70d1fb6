// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "filter/evidence.hpp"
#include "held_bytes.hpp"
#include "motion/scene_flow.hpp"
#include "motion/symmetric2.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// What points say of their velocity, spread over the cells around them.
class EvidenceMap {
 public:
  /// `fastest_mps`: of the filter's lattice along an axis; what is faster counts as that fast.
  EvidenceMap(int cells, double fastest_mps) : sums_{cells, cells}, fastest_mps_{fastest_mps} {
    touched_.reserve(sums_.size());
    evidence_.reserve(sums_.size());
  }

  /// Evidence for cells of the window, by ascending cell.
  const std::vector<VelocityEvidence>& gather(const std::vector<FlowVector>& vectors, const GridGeometry& window);

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(sums_, touched_, evidence_); }

 private:
  struct Sum {
    double weight{0};
    InformationSum velocity;
  };

  void spread(const FlowVector& vector, const GridGeometry& window);
  [[nodiscard]] VelocityEvidence evidence_of(int cell, const Sum& sum) const;

  Image<Sum> sums_;
  double fastest_mps_;
  std::vector<int> touched_;
  std::vector<VelocityEvidence> evidence_;
};

}  // namespace stereogrid
