// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cpu.hpp"
#include "images/levelling.hpp"
#include "support.hpp"

namespace stereogrid::test {

/// Additional pitch that the source does not include, from frame `first` to before frame `end`.
struct Nod {
  std::size_t first{0};
  std::size_t end{0};
  double pitch_rad{0};
};

inline void nod(const Rig& rig, double pitch_rad, StereoFrame& frame) {
  Rig turned{rig};
  turned.camera_pitch_rad = -pitch_rad;
  const Levelling levelling{turned};
  Cpu cpu{1};
  for (Image<std::uint8_t>* image : {&frame.left, &frame.right}) {
    Image<std::uint8_t> after{levelling.level_rig().width_px, levelling.level_rig().height_px};
    levelling.apply(cpu, std::as_const(*image).view(), after.view());
    // the camera stays: its image has the rows that it had
    const int down{static_cast<int>(levelling.level_rig().cy_px - rig.cy_px)};
    for (int v{0}; v < image->height(); ++v) {
      const int from{v + down};
      if (from < 0 || from >= after.height()) {
        std::fill_n(image->row(v), image->width(), std::uint8_t{0});
      } else {
        std::copy_n(after.row(from), image->width(), image->row(v));
      }
    }
  }
}

inline std::vector<StereoFrame> frames_of(const FrameSource& source, std::size_t count) {
  std::vector<StereoFrame> frames;
  for (std::size_t i{0}; i < count; ++i) frames.push_back(source.load(i));
  return frames;
}

/// The ground of every frame as seen with a rig whose calibration may be wrong. Pitches are of the images as they are,
/// not of the level ones.
inline std::vector<Ground> grounds_of(const std::vector<StereoFrame>& frames, const Rig& rig, const Nod& nodding = {}) {
  Config config{preset("default")};
  config.grid.length_m = 8;
  config.grid.width_m = 8;
  Pipeline pipeline{config, rig, {.threads = 2}};
  const double levelled_rad{Levelling{rig}.is_needed() ? rig.camera_pitch_rad : 0.0};
  std::vector<Ground> grounds;
  for (std::size_t i{0}; i < frames.size(); ++i) {
    StereoFrame frame{frames[i]};
    if (i >= nodding.first && i < nodding.end) nod(rig, nodding.pitch_rad, frame);
    grounds.push_back(pipeline.process(frame).ground);
    grounds.back().pitch_rad += levelled_rad;
  }
  return grounds;
}

struct WrongBy {
  double pitch_deg{0};
  double roll_deg{0};
  double height_m{0};
};

inline Rig wrong(Rig rig, const WrongBy& by) {
  rig.camera_pitch_rad += by.pitch_deg * degree;
  rig.camera_roll_rad += by.roll_deg * degree;
  rig.camera_height_m += by.height_m;
  return rig;
}

/// From the fifth frame on the two agree.
inline void expect_recovered(const std::vector<Ground>& right, const std::vector<Ground>& wrong) {
  ASSERT_EQ(right.size(), wrong.size());
  ASSERT_GT(right.size(), 5U);
  for (std::size_t i{4}; i < right.size(); ++i) {
    EXPECT_TRUE(wrong[i].estimated) << "frame " << i;
    EXPECT_NEAR(wrong[i].pitch_rad / degree, right[i].pitch_rad / degree, 0.1) << "frame " << i;
    EXPECT_NEAR(wrong[i].height_m, right[i].height_m, 0.03) << "frame " << i;
  }
}

/// Counts cells of the filtered grids that are known although no frame has observed them.
class NeverObservedCells {
 public:
  void add(const FrameResult& result) {
    // motion takes several frames; an obstacle beside the vehicle's grid is not confirmed
    has_moved_ = has_moved_ || std::ranges::any_of(result.obstacles, &Obstacle::moving);
    count(result.vehicle);
    count(result.world);
  }

  /// Cells that no moving obstacle explains: half of the mass must move.
  [[nodiscard]] int unfounded() const { return unfounded_; }

 private:
  void count(const GridLayers& layers) {
    for (std::size_t i{0}; i < layers.age_s.size(); ++i) {
      const float occupancy{layers.occupancy.data()[i]};
      const bool moves{occupancy > 0.5f && layers.moving.data()[i] > 0.5f};
      unfounded_ += std::isinf(layers.age_s.data()[i]) && is_known(occupancy) && !(moves && has_moved_) ? 1 : 0;
    }
  }

  bool has_moved_{false};
  int unfounded_{0};
};

}  // namespace stereogrid::test
