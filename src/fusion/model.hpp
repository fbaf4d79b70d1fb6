// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host_device.hpp"

namespace stereogrid {

/// Sources whose errors are independent: odds multiply, P = Π p / (Π p + Π (1 − p)). A source that is believed with
/// probability c, and else has said nothing, counts as ½ + c (p − ½).
struct IndependentPool {
  double occupied{1};
  double empty{1};

  STEREOGRID_HD void add(double p, double confidence) {
    const double believed{0.5 + confidence * (p - 0.5)};
    occupied *= believed;
    empty *= 1 - believed;
  }
  [[nodiscard]] STEREOGRID_HD double probability() const {
    const double all{occupied + empty};
    return all > 0 ? occupied / all : 0.5;
  }
};

/// Linear opinion pool, P = Σ w p / Σ w (Adarve et al. 2012): sources that share their errors do not add up to a
/// certainty that none of them has. w = c |2p − 1|, so that a source that knows nothing (½) does not dilute the others.
struct LinearPool {
  double weighted{0};
  double weights{0};

  STEREOGRID_HD void add(double p, double confidence) {
    const double weight{confidence * (p < 0.5 ? 1 - 2 * p : 2 * p - 1)};
    weighted += weight * p;
    weights += weight;
  }
  [[nodiscard]] STEREOGRID_HD double probability() const { return weights > 0 ? weighted / weights : 0.5; }
};

}  // namespace stereogrid
