// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "info/look.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>

#include "info/pair_faults.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {
namespace {

constexpr double degrees{57.29577951308232};
constexpr std::size_t first_tried{3};
constexpr std::size_t others_tried{5};
constexpr std::chrono::seconds longest_try{3};

std::set<std::size_t> spread(std::size_t frames, std::size_t count) {
  std::set<std::size_t> indices;
  const std::size_t steps{std::min(count, frames)};
  for (std::size_t i{0}; i < steps; ++i) indices.insert(steps == 1 ? 0 : i * (frames - 1) / (steps - 1));
  return indices;
}

double median(std::vector<double> values) {
  const auto middle{values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)};
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool has(const FrameResult& result, FrameStatus flag) {
  return std::ranges::count(result.status, flag) > 0;
}

/// How often something was seen, and in which frame first.
struct Tally {
  std::size_t frames{0};
  std::string first;

  void add(const std::string& name) {
    if (frames++ == 0) first = name;
  }
};

class Looking {
 public:
  Looking(const Input& input, const Config& config, std::size_t count)
      : input_{input},
        source_{*input.source},
        config_{config},
        pipeline_{
            config, source_.rig(), {.stages = false, .mask = input.mask, .extrinsics_given = input.extrinsics_given}},
        looked_at_{spread(source_.size(), count)},
        tried_{spread(source_.size(), others_tried)} {}

  Look look() {
    for (const std::size_t index : looked_at_) load(index);
    // the first ones that can be used, one after the other
    for (std::size_t index{0}, taken{0}; index < source_.size() && index < 10 && taken < first_tried; ++index) {
      tried_.insert(index);
      taken += unusable_.contains(index) ? 0 : 1;
    }
    const auto start{std::chrono::steady_clock::now()};
    for (const std::size_t index : tried_) {
      if (look_.tried >= first_tried && std::chrono::steady_clock::now() - start > longest_try) break;
      attempt(index);
    }
    complain();
    return std::move(look_);
  }

 private:
  void load(std::size_t index) {
    ++look_.looked_at;
    try {
      const StereoFrame frame{source_.load(index)};
      ++look_.usable;
      if (frame.right.empty()) return;
      if (is_without_texture(frame)) return blank_.add(frame.name);
      if (frame.left == frame.right) identical_.add(frame.name);
    } catch (const InputError& error) {
      unusable_.insert(index);
      look_.complaints.push_back(fmt::format("frame {} cannot be used: {}", source_.name(index), error.what()));
    }
  }

  void attempt(std::size_t index) {
    std::optional<StereoFrame> frame;
    try {
      frame = source_.load(index);
    } catch (const InputError&) {
      return;  // said where it was looked at
    }
    const double turned_rad{pipeline_.rig().camera_pitch_rad - pipeline_.level_rig().camera_pitch_rad};
    const FrameResult& result{pipeline_.process(*frame)};
    ++look_.tried;
    const bool matches{!has(result, FrameStatus::few_matches)};
    if (!result.status.empty() && (!matches || has(result, FrameStatus::road_unknown))) ++unknown_;
    if (matches && result.ground.estimated && !has(result, FrameStatus::road_unknown)) {
      found_.push_back(result.ground);
      found_.back().pitch_rad += turned_rad;
    } else if (matches) {
      no_road_.add(frame->name);
      if (no_road_.frames == 1 && is_upside_down(*frame, config_, source_.rig())) upside_down_ = true;
    }
    if (frame->right.empty() || is_without_texture(*frame) || frame->left == frame->right) return;
    if (const auto complaint{io::complaint_if_swapped(*frame)}) {
      if (swapped_.frames == 0) swapped_complaint_ = *complaint;
      swapped_.add(frame->name);
    } else if (!matches) {
      unmatched_.add(frame->name);
      if (unmatched_.frames == 1) fault_ = fault_of_pair(input_, index, *frame);
    }
  }

  [[nodiscard]] std::string in_frames(const Tally& tally, std::size_t all) const {
    return fmt::format("in {} of {} frames (first: {})", tally.frames, all, tally.first);
  }

  void say(std::string text) { look_.complaints.push_back(std::move(text)); }

  void complain() {
    if (identical_.frames > 0) {
      say(fmt::format("left and right are the same image {}: give the right camera's images.",
                      in_frames(identical_, look_.looked_at)));
    }
    if (blank_.frames > 0) {
      say(fmt::format("an image is black or without texture {}: is a lens covered, or the exposure far off?",
                      in_frames(blank_, look_.looked_at)));
    }
    if (swapped_.frames > 0) {
      say(fmt::format("{} So it is {}.", swapped_complaint_, in_frames(swapped_, look_.tried)));
    }
    if (unmatched_.frames > 0) {
      say(fmt::format("left and right hardly match {}: {}", in_frames(unmatched_, look_.tried), fault_));
    }
    complain_of_road();
    const bool is_nothing_known{look_.tried > 0 && unknown_ == look_.tried};
    look_.is_hopeless = look_.usable == 0 || swapped_.frames > 0 || is_nothing_known;
  }

  void complain_of_road() {
    const Rig& rig{source_.rig()};
    look_.road_found = found_.size();
    if (upside_down_) {
      say("the images are upside down: the road is above. Turn both by 180° and exchange left and right.");
    } else if (const Rig & mounted{pipeline_.rig()}; mounted != rig) {
      say(
          fmt::format("the camera is not mounted as assumed, {:.3g} m above the road with a pitch of {:.1f}° (down). A "
                      "run finds that out, too, but knows nothing until then. For calibration.yaml: {}",
                      rig.camera_height_m, rig.camera_pitch_rad * degrees, io::mount_line(mounted)));
    } else if (no_road_.frames > 0 && config_.ground.estimate) {
      say(
          fmt::format("road not found {}: {}: {:.3g} m above the road and a pitch of {:.1f}° (down) are assumed. "
                      "Measure them, and give mount.camera_height_m and mount.camera_pitch_rad.",
                      in_frames(no_road_, look_.tried),
                      input_.recording != nullptr && !input_.recording->contents().calibration.has_mounting
                          ? "the calibration has no mounting"
                          : "the mounting in the calibration may be wrong",
                      rig.camera_height_m, rig.camera_pitch_rad * degrees));
    }
    if (found_.empty()) return;
    const auto median_of = [&](double Ground::*what) {
      std::vector<double> values;
      for (const Ground& ground : found_) values.push_back(ground.*what);
      return median(std::move(values));
    };
    look_.road = {median_of(&Ground::height_m), median_of(&Ground::pitch_rad), median_of(&Ground::roll_rad), true};
    constexpr double noticeable_deg{2};
    if (pipeline_.rig() == rig && std::abs(look_.road.pitch_rad - rig.camera_pitch_rad) * degrees > noticeable_deg) {
      say(
          fmt::format("the camera looks down by {:.1f}°, not by {:.1f}° as assumed. Results are better with "
                      "mount.camera_pitch_rad: {:.3f} in the calibration.",
                      look_.road.pitch_rad * degrees, rig.camera_pitch_rad * degrees, look_.road.pitch_rad));
    }
  }

  const Input& input_;
  const FrameSource& source_;
  const Config& config_;
  Pipeline pipeline_;
  std::set<std::size_t> looked_at_;
  std::set<std::size_t> tried_;
  std::set<std::size_t> unusable_;
  std::vector<Ground> found_;
  std::size_t unknown_{0};  ///< frames tried of which nothing is known
  Tally identical_;
  Tally blank_;
  Tally swapped_;
  Tally unmatched_;
  Tally no_road_;
  std::string swapped_complaint_;
  std::string fault_;
  bool upside_down_{false};
  Look look_;
};

}  // namespace

Look look_at_frames(const Input& input, const Config& config, std::size_t count) {
  return Looking{input, config, count}.look();
}

}  // namespace stereogrid::app
