// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stereogrid/export.hpp"

namespace stereogrid::io {

/// Depth of the pixels of a stereo_msgs/DisparityImage, Z = f·T/d. Some publishers send u_right − u_left: where the
/// limits are not above 0, the sign of d, f and T does not count.
class STEREOGRID_EXPORT DisparityDepth {
 public:
  /// `focal_px`, `baseline_m`, `min_px`, `max_px`: f, T, min_disparity and max_disparity of the message; no limits
  /// unless min < max. `name`: for messages. Throws InputError: f·T is 0 or not finite.
  DisparityDepth(const std::string& name, float focal_px, float baseline_m, float min_px, float max_px);

  /// m; 0: no disparity, or outside the limits.
  [[nodiscard]] double operator()(float disparity_px) const;

 private:
  double focal_baseline_pxm_;
  float min_px_;
  float max_px_;
  bool is_negative_;
};

}  // namespace stereogrid::io
