// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/scenes/scene.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

/// Fills in the defaults. Throws InputError for an unknown scene or a value out of range.
[[nodiscard]] SceneOptions completed(SceneOptions options);

[[nodiscard]] World build_world(const SceneOptions& options);

}  // namespace stereogrid::scenes
