// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/disparity_depth.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stereogrid/error.hpp"

namespace stereogrid::io {

DisparityDepth::DisparityDepth(const std::string& name, float focal_px, float baseline_m, float min_px, float max_px)
    : focal_baseline_pxm_{std::abs(double{focal_px} * baseline_m)},
      min_px_{min_px},
      max_px_{max_px},
      is_negative_{min_px < 0 && max_px <= 0} {
  if (focal_baseline_pxm_ > 0 && std::isfinite(focal_baseline_pxm_)) return;
  throw InputError{name, fmt::format("the DisparityImage has f {:g} px and T {:g} m.", focal_px, baseline_m),
                   "Both are above 0: correct what publishes it, or record depth."};
}

double DisparityDepth::operator()(float disparity_px) const {
  const bool is_outside{max_px_ > min_px_ && (disparity_px < min_px_ || disparity_px > max_px_)};
  const float d{is_negative_ ? -disparity_px : disparity_px};
  return is_outside || !(d > 0) ? 0 : focal_baseline_pxm_ / d;
}

}  // namespace stereogrid::io
