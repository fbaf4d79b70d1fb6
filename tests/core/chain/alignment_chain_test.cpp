// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The whole pipeline on scenes whose right camera has been turned a little.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "backend/reference.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid {
namespace {

using scenes::Scene;

constexpr RowTerms none{};
/// As found in KITTI's drives.
constexpr RowTerms like_kitti{-0.2, 0.0, 0.0, 0.53, -0.15};

StereoFrame turned(const Scene& scene, std::size_t index, const RowTerms& terms) {
  StereoFrame frame{scene.load(index)};
  const Image<std::uint8_t> right{frame.right};
  RowOffsets opposite{terms, scene.rig().cx_px, scene.rig().cy_px};
  for (double& term : opposite.terms) term = -term;
  Reference reference;
  align_rows(reference, right.view(), opposite, frame.right.view());
  return frame;
}

Config config_with(bool align) {
  Config config{preset("default")};
  config.matching.align_rows = align;
  return config;
}

/// Share of the road's matched pixels that are off by more than a pixel, in the last frame.
double wrong_on_the_road(const Scene& scene, const RowTerms& terms, bool align) {
  Pipeline pipeline{config_with(align), scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i + 1 < scene.size(); ++i) pipeline.process(turned(scene, i, terms));
  const FrameResult& result{pipeline.process(turned(scene, scene.size() - 1, terms))};
  const Image<float> truth{scene.truth(scene.size() - 1).disparity};
  int matched{0};
  int wrong{0};
  for (std::size_t i{0}; i < truth.size(); ++i) {
    const float found{result.stages.road_disparity.data()[i]};
    if (found <= 0 || truth.data()[i] <= 0) continue;
    ++matched;
    if (std::abs(found - truth.data()[i]) > 1) ++wrong;
  }
  return static_cast<double>(wrong) / matched;
}

TEST(AlignmentChain, ATurnedCameraIsPutRight) {
  for (const char* text : {"street?width=1242&height=375&frames=1", "street?width=1242&height=375&frames=3"}) {
    const Scene scene{scenes::parse_scene(text), 2};
    const double fine{wrong_on_the_road(scene, none, false)};
    const double off{wrong_on_the_road(scene, like_kitti, false)};
    const double aligned{wrong_on_the_road(scene, like_kitti, true)};
    EXPECT_GT(off, 0.2);
    EXPECT_LT(aligned, fine + 0.02);
  }
}

TEST(AlignmentChain, AlignedCamerasAreLeftAlone) {
  const Scene scene{scenes::parse_scene("street?frames=3"), 2};
  Pipeline with{config_with(true), scene.rig(), {.threads = 2}};
  Pipeline without{config_with(false), scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const Image<float> observed{with.process(scene.load(i)).observed};
    EXPECT_EQ(observed, without.process(scene.load(i)).observed) << i;
  }
}

TEST(AlignmentChain, ReferenceAgrees) {
  const Scene scene{scenes::parse_scene("crossing?width=240&height=150&frames=2"), 2};
  const auto config = [](bool align) {
    Config small{config_with(align)};
    small.matching.window_px = 7;
    small.matching.disparities = 24;
    return small;
  };
  Pipeline cpu{config(true), scene.rig(), {.threads = 2}};
  Pipeline reference{config(true), scene.rig(), {.back_end = BackEnd::reference}};
  Pipeline without{config(false), scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const StereoFrame frame{turned(scene, i, {0.6, 0, 0, 0, 0})};
    const StageImages& found{cpu.process(frame).stages};
    const StageImages& wanted{reference.process(frame).stages};
    EXPECT_EQ(found.road_disparity, wanted.road_disparity) << i;
    EXPECT_EQ(found.obstacle_disparity, wanted.obstacle_disparity) << i;
    EXPECT_NE(found.obstacle_disparity, without.process(frame).stages.obstacle_disparity) << "nothing was aligned";
  }
}

TEST(AlignmentChain, GivenDisparitiesNeedNone) {
  const Scene scene{scenes::parse_scene("street?frames=1"), 2};
  StereoFrame frame{scene.load(0)};
  frame.right = {};
  frame.disparity = scene.truth(0).disparity;
  Pipeline pipeline{config_with(true), scene.rig(), {.threads = 1}};
  EXPECT_GT(pipeline.process(frame).road_density, 0.1);
}

}  // namespace
}  // namespace stereogrid
