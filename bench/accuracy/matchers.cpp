// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/matchers.hpp"

#include <memory>
#include <opencv2/calib3d.hpp>

#include "backend/cpu.hpp"
#include "matching/matching.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::bench {
namespace {

/// No pixel has both.
Matched joined(const Image<float>& obstacle, const Image<float>& road) {
  Matched matched{obstacle, Image<Surface>{obstacle.width(), obstacle.height()}, {}};
  for (int v{0}; v < road.height(); ++v) {
    for (int u{0}; u < road.width(); ++u) {
      if (obstacle(u, v) > 0) matched.label(u, v) = Surface::obstacle;
      if (road(u, v) <= 0) continue;
      matched.label(u, v) = Surface::road;
      matched.disparity(u, v) = road(u, v);
    }
  }
  return matched;
}

Matcher on_true_road(const std::string& name, const std::string& peer, const TruthSet& set,
                     const MatchingConfig& config) {
  struct Room {
    Cpu cpu{0};
    Room(const Rig& rig, const MatchingConfig& config)
        : space{rig.width_px, rig.height_px, config, cpu.threads()}, matches{rig.width_px, rig.height_px} {}
    MatchingSpace space;
    Matches matches;
  };
  const auto room{std::make_shared<Room>(set.rig, config)};
  return {name, peer, [room, config](const TruthFrame& truth) {
            match(room->cpu, truth.frame.left.view(), truth.frame.right.view(), truth.plane, config, room->space,
                  room->matches);
            Matched matched{joined(room->matches.obstacle, room->matches.road)};
            matched.confidence = room->matches.confidence;
            return matched;
          }};
}

Matcher in_pipeline(const std::string& name, const std::string& peer, const TruthSet& set, const Config& config) {
  const auto pipeline{std::make_shared<Pipeline>(config, set.rig)};
  return {name, peer, [pipeline](const TruthFrame& truth) {
            const FrameResult& result{pipeline->process(truth.frame)};
            Matched matched{joined(result.stages.obstacle_disparity, result.stages.road_disparity)};
            matched.confidence = result.stages.match_confidence;
            return matched;
          }};
}

cv::Mat mat_of(const Image<std::uint8_t>& image) {
  return cv::Mat{image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())};
}

Matcher of_opencv(const std::string& name, const cv::Ptr<cv::StereoMatcher>& matcher) {
  return {name, "", [matcher](const TruthFrame& truth) {
            cv::Mat sixteenths;
            matcher->compute(mat_of(truth.frame.left), mat_of(truth.frame.right), sixteenths);
            Matched matched{Image<float>{sixteenths.cols, sixteenths.rows}, {}, {}};
            for (int v{0}; v < sixteenths.rows; ++v) {
              for (int u{0}; u < sixteenths.cols; ++u) {
                matched.disparity(u, v) = std::max(0.0F, static_cast<float>(sixteenths.at<short>(v, u)) / 16);
              }
            }
            return matched;
          }};
}

Matcher semi_global_of_opencv(const std::string& name, int disparities, int mode) {
  return of_opencv(name, cv::StereoSGBM::create(0, disparities, 5, 200, 800, 1, 0, 10, 100, 2, mode));
}

}  // namespace

std::vector<Matcher> matchers_for(const TruthSet& set, const Config& config) {
  Config correlation{config};
  correlation.matching.method = MatchingMethod::correlation;
  correlation.matching.disparities = set.disparities;
  Config wide{correlation};
  wide.matching.window_px = 21;
  Config semi_global{correlation};
  semi_global.matching.method = MatchingMethod::semi_global;
  const std::string own_window{"correlation " + std::to_string(correlation.matching.window_px)};
  const std::string block{"StereoBM 21"};
  const std::string three_way{"StereoSGBM 3WAY"};
  return {
      of_opencv(block, cv::StereoBM::create(set.disparities, 21)),
      on_true_road("correlation 21", block, set, wide.matching),
      on_true_road(own_window, block, set, correlation.matching),
      in_pipeline(own_window + ", pipeline", block, set, correlation),
      semi_global_of_opencv(three_way, set.disparities, cv::StereoSGBM::MODE_SGBM_3WAY),
      semi_global_of_opencv("StereoSGBM 5 paths", set.disparities, cv::StereoSGBM::MODE_SGBM),
      on_true_road("semi_global", three_way, set, semi_global.matching),
      in_pipeline("semi_global, pipeline", three_way, set, semi_global),
  };
}

}  // namespace stereogrid::bench
