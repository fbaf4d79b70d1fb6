// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/matches.hpp"
#include "geometry/road_plane.hpp"
#include "matching/checks/candidates.hpp"
#include "matching/checks/simd.hpp"
#include "matching/checks/speckles.hpp"
#include "matching/model.hpp"
#include "matching/padded.hpp"
#include "matching/tops/tops.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// A range of shifts to search: first … first + count − 1.
struct Shifts {
  int first{0};
  int count{0};
};

/// The road hypothesis searches this far on both sides of the ground plane's disparity.
constexpr int road_margin_px{3};
constexpr Shifts road_shifts{-road_margin_px, 2 * road_margin_px + 1};

/// Working memory of `match`. Allocated once per pipeline.
struct MatchingWorkspace {
  MatchingWorkspace(int width, int height, const MatchingConfig& config, int threads);

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(left, right, sheared, short_left, short_right_reversed, short_sheared, textured, speckles,
                           memory, rows, decisions, textures, tops);
  }

  Padded<std::uint8_t> left, right, sheared;                             ///< grey levels
  Padded<std::uint8_t> short_left, short_right_reversed, short_sheared;  ///< short census
  Padded<std::uint8_t> textured;                                         ///< 1 where a window has contrast
  Speckles speckles;
  std::vector<std::uint8_t> memory;  ///< CPU: working memory of the bands, see make_room
  std::vector<RowCandidates> rows;   ///< CPU: of each band
  std::vector<ClassifyWorkspace> decisions;
  std::vector<TextureWorkspace> textures;
  Image<ThinTop> tops;  ///< empty unless has_tops
};

/// Allocates what the CPU works in besides. Without it the first frame does.
void make_room(Cpu& cpu, const MatchingConfig& config, MatchingWorkspace& space);
inline void make_room(Reference& /*reference*/, const MatchingConfig& /*config*/, MatchingWorkspace& /*space*/) {}

/// Double correlation (T-ITS 2012, III-C): every pixel is matched as part of an upright surface (constant disparity in
/// the window) and of the road (disparity of the plane, window sheared along). The cheaper hypothesis gives label and
/// disparity, if it passes the texture and uniqueness tests and no cheaper pixel of the row claims the same place of
/// the right image. Cost: Hamming distance of centre-symmetric census, summed over the window; outside the image the
/// border is repeated.
void match(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingWorkspace& space, Matches& matches);
void match(Reference& reference, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingWorkspace& space, Matches& matches);

/// The candidates alone, row by row. Upright shifts and all costs are set everywhere. The CPU's correlation sets other
/// members only where they can matter: level ones where they cost less than upright ones, upright ones where they can
/// be accepted. Exposed for tests.
void find_candidates(Cpu& cpu, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
                     const MatchingConfig& config, MatchingWorkspace& space, CandidateSink& sink);
void find_candidates(Reference& reference, View<const std::uint8_t> left, View<const std::uint8_t> right,
                     const RoadPlane& plane, const MatchingConfig& config, MatchingWorkspace& space,
                     CandidateSink& sink);

/// The upright hypothesis searches all disparities.
Shifts upright_shifts(const MatchingConfig& config);

/// Sum of |L(u+1) − L(u−1)| that a window must have.
int least_texture(const MatchingConfig& config);

/// Smallest patches that stay.
SpeckleSizes speckle_sizes(const MatchingConfig& config);

/// Confidence model and cost limit.
ConfidenceModel confidence_model(const MatchingConfig& config);

/// Whether thin tops are searched, and how.
bool has_tops(const MatchingConfig& config);
TopRules top_rules(const MatchingConfig& config);

/// The share by which a runner-up must cost more, in 1/1024.
int uniqueness_1024(const MatchingConfig& config);

}  // namespace stereogrid
