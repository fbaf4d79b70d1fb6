// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/scenes/scene.hpp"

#include <algorithm>

#include "targets.hpp"

namespace stereogrid::fuzz {

void scene(Bytes input) {
  scenes::SceneOptions options;
  if (!accepts([&] { options = scenes::parse_scene(text_of(input)); })) return;
  // larger images are only slower
  options.width_px = std::min(options.width_px, 24);
  options.height_px = std::min(options.height_px, 16);
  accepts([&] {
    const scenes::Scene rendered{options, 1};
    const std::size_t last{rendered.size() - 1};
    const StereoFrame frame{rendered.load(last)};
    require(frame.left.width() == options.width_px && frame.right.height() == options.height_px,
            "a scene's images have another size");
    require(rendered.truth(last).disparity.width() == options.width_px, "a scene's truth has another size");
  });
}

}  // namespace stereogrid::fuzz
