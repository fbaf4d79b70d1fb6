// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid::capture {

struct ReplayOptions {
  bool loops{false};     ///< begins again after the last frame
  double speed{1};       ///< 2: twice as fast; more than 0. Stamps stay those of the recording, moved to now
  std::size_t first{0};  ///< frames [first, last) of the source
  std::size_t last{0};   ///< 0: all
};

/// A recording as if it happened now: each frame comes when its stamp says. Where loading takes longer than that,
/// frames come late and none is lost for it. The source has to live longer.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<LiveSource> replay(const FrameSource& source,
                                                                   const ReplayOptions& options = {});

}  // namespace stereogrid::capture
