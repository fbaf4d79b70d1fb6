// SPDX-License-Identifier: Apache-2.0
//
// Pairs whose images differ: right cameras turned a little, and unequal exposures, whose saturated areas cannot match.
#include "backend/reference.hpp"
#include "chain_run.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

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
    const Scene scene{text};
    const double fine{wrong_on_the_road(scene, none, false)};
    const double off{wrong_on_the_road(scene, like_kitti, false)};
    const double aligned{wrong_on_the_road(scene, like_kitti, true)};
    EXPECT_GT(off, 0.2);
    EXPECT_LT(aligned, fine + 0.02);
  }
}

TEST(AlignmentChain, AlignedCamerasAreLeftAlone) {
  const Scene scene{"street?frames=3"};
  Pipeline with{config_with(true), scene.rig(), {.threads = 2}};
  Pipeline without{config_with(false), scene.rig(), {.threads = 2}};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const Image<float> observed{with.process(scene.load(i)).observed};
    EXPECT_EQ(observed, without.process(scene.load(i)).observed) << i;
  }
}

TEST(AlignmentChain, ReferenceAgrees) {
  const Scene scene{"crossing?width=240&height=150&frames=2"};
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
  const Scene scene{"street?frames=1"};
  StereoFrame frame{scene.load(0)};
  frame.right = {};
  frame.disparity = scene.truth(0).disparity;
  Pipeline pipeline{config_with(true), scene.rig(), {.threads = 1}};
  EXPECT_GT(pipeline.process(frame).road_density, 0.1);
}

using Grey = Image<std::uint8_t>;

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
  const Scene scene{street};
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
  const Scene scene{street};
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
  const Scene scene{street};
  Pipeline pipeline{small_grid(), scene.rig(), {.threads = 2}};
  for (const double gain : {1.0, 0.4, 2.0}) {
    StereoFrame frame{scene.load(0)};
    for (Grey* image : {&frame.left, &frame.right}) multiply(*image, gain);
    EXPECT_FALSE(names(pipeline.process(frame), "exposure")) << gain;
    pipeline.reset();
  }
}

TEST(ExposureChain, PairsThatDoNotBelongTogetherAreStillFound) {
  const Scene scene{street};
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
  const Scene scene{street};
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
