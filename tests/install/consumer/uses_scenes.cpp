// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <stereogrid/pipeline.hpp>
#include <stereogrid/scenes/scene.hpp>

#include <cstdio>

int main() {
  const stereogrid::scenes::Scene scene{stereogrid::scenes::parse_scene("scene:empty?frames=1&width=256&height=160")};
  stereogrid::Pipeline pipeline{stereogrid::preset("default"), scene.rig()};
  const stereogrid::FrameResult& result{pipeline.process(scene.load(0))};
  std::printf("road matched in %.0f %% of the pixels\n", 100 * result.road_density);
  return result.road_density > 0.05 ? 0 : 1;
}
