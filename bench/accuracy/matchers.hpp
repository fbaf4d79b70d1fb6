// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "accuracy/sets.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid::bench {

/// Result of a matcher for a pair.
struct Matched {
  Image<float> disparity;
  Image<Surface> label;     ///< empty: the matcher has no surfaces
  Image<float> confidence;  ///< in [0, 1]; empty: none
};

struct Matcher {
  std::string name;
  std::string peer;  ///< name of OpenCV's that ours is compared with on the pixels that both match; "": is OpenCV's
  std::function<Matched(const TruthFrame&)> match;
};

/// Ours and OpenCV's for the frames of one set. Ours are there twice: on the road plane of the truth, and as they are
/// used, in the Pipeline, which estimates the plane from frame to frame; frames have to come in order. `config`: what
/// ours have in common; method, window 21 and disparities are set here.
std::vector<Matcher> matchers_for(const TruthSet& set, const Config& config);

}  // namespace stereogrid::bench
