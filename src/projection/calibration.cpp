// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "projection/calibration.hpp"

#include <algorithm>
#include <cstddef>

namespace stereogrid {
namespace {

struct Knot {
  double model;
  double calibrated;
};

constexpr Knot knots[]{{0, 0},       {0.02, 0.005}, {0.1, 0.03},   {0.2, 0.04},  {0.3, 0.14},
                       {0.4, 0.36},  {0.42, 0.455}, {0.45, 0.475}, {0.5, 0.5},   {0.502, 0.502},
                       {0.51, 0.65}, {0.55, 0.84},  {0.7, 0.9},    {0.85, 0.95}, {1, 0.97}};

double interpolated(double model) {
  const Knot* above{
      std::find_if(std::begin(knots) + 1, std::end(knots) - 1, [&](const Knot& knot) { return knot.model >= model; })};
  const Knot& below{above[-1]};
  const double part{(model - below.model) / (above->model - below.model)};
  return below.calibrated + std::min(part, 1.0) * (above->calibrated - below.calibrated);
}

}  // namespace

Calibration::Calibration() {
  for (std::size_t k{0}; k < table_.size(); ++k) {
    table_[k] = static_cast<float>(interpolated(static_cast<double>(k) / calibration_steps));
  }
}

float Calibration::operator()(float probability) const {
  return calibrated(table_.data(), probability);
}

void Calibration::apply(View<float> cells) const {
  for (int iy{0}; iy < cells.height; ++iy) {
    float* row{cells.row(iy)};
    for (int ix{0}; ix < cells.width; ++ix) row[ix] = (*this)(row[ix]);
  }
}

}  // namespace stereogrid
