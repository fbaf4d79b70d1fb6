// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace stereogrid::io {

/// Paths of a frame's files in a truth/ folder.
struct TruthFiles {
  std::filesystem::path disparity, label, instance, seen_by_both, cells;

  TruthFiles(const std::filesystem::path& folder, const std::string& name)
      : disparity{folder / "disparity" / (name + ".png")},
        label{folder / "label" / (name + ".png")},
        instance{folder / "instance" / (name + ".png")},
        seen_by_both{folder / "seen_by_both" / (name + ".png")},
        cells{folder / "cells" / (name + ".npz")} {}
};

/// disparity/NAME.png holds disparities times this.
constexpr float disparity_scale{256};

}  // namespace stereogrid::io
