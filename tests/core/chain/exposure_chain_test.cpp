// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Cameras with unequal exposures: saturated areas cannot match, which does not make them another scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "chain_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

using Grey = Image<std::uint8_t>;
using scenes::Scene;

constexpr const char* street{"street?width=480&height=160&focal=300"};

void expose(Grey& image, const std::function<double(double)>& exposed) {
  for (std::uint8_t& grey : image) {
    grey = static_cast<std::uint8_t>(std::clamp(std::round(exposed(static_cast<double>(grey))), 0.0, 255.0));
  }
}

void multiply(Grey& image, double gain) {
  expose(image, [gain](double grey) { return gain * grey; });
}

bool names(const FrameResult& result, const std::string& text) {
  return std::ranges::any_of(result.warnings,
                             [&](const Warning& warning) { return warning.text.find(text) != std::string::npos; });
}

void expect_known(const FrameResult& result, const std::string& brighter) {
  EXPECT_TRUE(result.status.empty());
  EXPECT_TRUE(result.ground.estimated);
  EXPECT_EQ(result.warnings.size(), 1u);
  EXPECT_TRUE(names(result, "the " + brighter + " image is "));
  EXPECT_TRUE(names(result, "set both cameras to the same exposure"));
}

TEST(ExposureChain, EitherImageMayBeBrighter) {
  const Scene scene{scenes::parse_scene(street), 2};
  for (const double gain : {0.3, 0.5, 1.6, 2.0, 2.4}) {
    SCOPED_TRACE(gain);
    StereoFrame left{scene.load(0)};
    StereoFrame right{left};
    multiply(left.left, gain);
    multiply(right.right, gain);
    Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
    expect_known(pipeline.process(left), gain > 1 ? "left" : "right");
    pipeline.reset();
    expect_known(pipeline.process(right), gain > 1 ? "right" : "left");
  }
}

TEST(ExposureChain, GammaAndOffsetAreExposuresToo) {
  const Scene scene{scenes::parse_scene(street), 2};
  const auto gamma = [](double grey) { return 255 * std::pow(grey / 255, 0.4); };
  const auto brighter = [](double grey) { return grey + 80; };
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (const std::function<double(double)>& exposed : std::vector<std::function<double(double)>>{gamma, brighter}) {
    StereoFrame frame{scene.load(0)};
    expose(frame.right, exposed);
    expect_known(pipeline.process(frame), "right");
    pipeline.reset();
  }
}

TEST(ExposureChain, EqualExposuresAreNoMatterForAWarning) {
  const Scene scene{scenes::parse_scene(street), 2};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (const double gain : {1.0, 0.4, 2.0}) {
    StereoFrame frame{scene.load(0)};
    for (Grey* image : {&frame.left, &frame.right}) multiply(*image, gain);
    EXPECT_FALSE(names(pipeline.process(frame), "exposure")) << gain;
    pipeline.reset();
  }
}

TEST(ExposureChain, PairsThatDoNotBelongTogetherAreStillFound) {
  const Scene scene{scenes::parse_scene(street), 3};
  const auto swapped = [](StereoFrame& frame) { std::swap(frame.left, frame.right); };
  const auto late = [&](StereoFrame& frame) { frame.right = scene.load(1).right; };
  const auto rows_off = [](StereoFrame& frame) {
    std::rotate(frame.right.begin(), frame.right.begin() + 12 * frame.right.width(), frame.right.end());
  };
  const auto noise = [](StereoFrame& frame) {
    std::mt19937 generator{5};
    frame.right = noise_image(frame.left.width(), frame.left.height(), generator);
  };
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (const std::function<void(StereoFrame&)>& spoil :
       std::vector<std::function<void(StereoFrame&)>>{swapped, late, rows_off, noise}) {
    for (const double gain : {0.3, 1.6, 2.0, 3.0}) {
      for (Grey StereoFrame::*side : {&StereoFrame::left, &StereoFrame::right}) {
        StereoFrame frame{scene.load(0)};
        spoil(frame);
        multiply(frame.*side, gain);
        EXPECT_EQ(pipeline.process(frame).status, std::vector<FrameStatus>{FrameStatus::few_matches}) << gain;
        pipeline.reset();
      }
    }
  }
}

// Hardly anything is left to match, and the reason is named.
TEST(ExposureChain, AWhiteImageIsRejectedForItsExposure) {
  const Scene scene{scenes::parse_scene(street), 2};
  StereoFrame frame{scene.load(0)};
  multiply(frame.right, 30);
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  const FrameResult& result{pipeline.process(frame)};
  EXPECT_EQ(result.status, std::vector<FrameStatus>{FrameStatus::few_matches});
  EXPECT_TRUE(names(result, "the right image is "));
  EXPECT_TRUE(names(result, "% of it is saturated"));
}

}  // namespace
}  // namespace stereogrid::test
