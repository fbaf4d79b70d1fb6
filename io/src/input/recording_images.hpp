// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {

struct Size {
  int width_px{0};
  int height_px{0};

  auto operator<=>(const Size&) const = default;
};

/// The left images say how large and how deep the images of the recording are: a few of them where they are alike, else
/// most of many.
Size look_at_images(RecordingContents& contents);

}  // namespace stereogrid::io
