// SPDX-License-Identifier: Apache-2.0
//
// Images in memory of another program, here of a camera driver that has both side by side in one buffer: the pipeline
// reads them in place, without a copy.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

/// Stands for the driver of a camera: rows of the left image, each followed by the row of the right one.
class Driver {
 public:
  [[nodiscard]] const stereogrid::Rig& rig() const { return scene_.rig(); }

  /// Time of exposure, ns. Fills the buffer.
  std::int64_t grab(std::size_t index) {
    const stereogrid::StereoFrame frame{scene_.load(index)};
    auto to{buffer_.begin()};
    for (int v{0}; v < rig().height_px; ++v) {
      to = std::copy_n(frame.left.row(v), rig().width_px, to);
      to = std::copy_n(frame.right.row(v), rig().width_px, to);
    }
    return frame.stamp_ns;
  }
  [[nodiscard]] const std::uint8_t* pixels() const { return buffer_.data(); }

 private:
  stereogrid::scenes::Scene scene_{stereogrid::scenes::parse_scene("street?frames=6")};
  std::vector<std::uint8_t> buffer_ = std::vector<std::uint8_t>(2U * static_cast<std::size_t>(scene_.rig().width_px) *
                                                                static_cast<std::size_t>(scene_.rig().height_px));
};

}  // namespace

int main() {
  Driver driver;
  const int width{driver.rig().width_px};
  const int height{driver.rig().height_px};
  stereogrid::Pipeline pipeline{stereogrid::preset("default"), driver.rig()};
  stereogrid::FrameResult result;  // its memory is used again
  for (std::size_t i{0}; i < 6; ++i) {
    stereogrid::StereoFrame frame;  // time and pose; without images
    frame.index = static_cast<std::int64_t>(i);
    frame.stamp_ns = driver.grab(i);
    const stereogrid::FrameImages images{.left = {driver.pixels(), width, height, 2 * width},
                                         .right = {driver.pixels() + width, width, height, 2 * width}};
    pipeline.process(frame, images, result);
    const auto confirmed{std::ranges::count_if(result.obstacles, &stereogrid::Obstacle::confirmed)};
    std::printf("frame %zu: %d obstacles\n", i, static_cast<int>(confirmed));
  }
}
