// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/frame_tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid::app {
namespace {

constexpr double degrees{57.29577951308232};
constexpr double pitch_step_rad{1e-4};  // resolution of FrameTally::road_pitches

std::string text_of(const io::FrameSummary& frame, FrameStatus flag) {
  const auto found{std::ranges::find(frame.warnings, flag, &Warning::status)};
  return found == frame.warnings.end() ? "" : found->text;
}

/// Flags of time and pose describe how the frames follow each other, not the images.
bool is_of_images(FrameStatus flag) {
  return flag > FrameStatus::pose_jump;
}

double median_pitch_rad(const FrameTally& tally) {
  std::size_t all{0};
  for (const auto& [pitch, frames] : tally.road_pitches) all += frames;
  std::size_t below{0};
  for (const auto& [pitch, frames] : tally.road_pitches) {
    below += frames;
    if (2 * below > all) return pitch * pitch_step_rad;
  }
  return 0;
}

class DriveDiagnosis {
 public:
  DriveDiagnosis(const FrameTally& tally, const TallyContext& context) : tally_{tally}, context_{context} {}

  Findings diagnose() {
    report_exposure();
    for (std::size_t i{0}; i < tally_.flags.size(); ++i) report_flag(static_cast<FrameStatus>(i));
    report_pitch();
    report_height();
    report_near_ground();
    report_unknown_grids();
    return std::move(findings_);
  }

 private:
  void say(std::string text) { findings_.texts.push_back(std::move(text)); }

  [[nodiscard]] std::string share(const FrameCount& count) const {
    return fmt::format("{} of {} frames", count.frames, tally_.frames);
  }

  void report_exposure() {
    const FrameCount& unequal{tally_.unequal_exposure};
    if (unequal.frames == 0) return;
    say(fmt::format("in {} (first: {}) {}", share(unequal), unequal.first.name, *unequal.first.exposure_warning));
  }

  void report_flag(FrameStatus flag) {
    if (flag == FrameStatus::road_unknown) return report_road();  // also of frames without the flag
    const FrameCount& flagged{tally_.with(flag)};
    if (flagged.frames == 0 || !is_of_images(flag)) return;
    if (flag == FrameStatus::few_matches) {
      const auto frame{context_.frame_at(flagged.first.index)};
      if (!frame || frame->disparity.empty()) return report_matches(flagged, frame);
      if (const std::string fault{fault_of_scale(*frame, context_)}; !fault.empty()) return say(fault);
    }
    say(fmt::format("in {} (first: {}): {}: {}", share(flagged), flagged.first.name,
                    names_of(flag)[static_cast<std::size_t>(flag)], text_of(flagged.first, flag)));
  }

  void report_matches(const FrameCount& unmatched, const std::optional<StereoFrame>& frame) {
    PairFault fault;
    if (frame) fault = fault_of_pair(context_, *frame);
    findings_.are_sides_swapped = fault.is_swapped;
    if (fault.text.empty()) {
      fault.text = unmatched.first.exposure_warning.value_or(
          "are they of the same instant and the same place, rectified with this calibration, and not all noise?");
    }
    say(fmt::format("in {} left and right image hardly match, and the grid is unknown (first: {}): {}",
                    share(unmatched), unmatched.first.name, fault.text));
  }

  // Single frames without a road occur on every drive; its plane is carried over.
  void report_road() {
    constexpr std::size_t every{20};
    const FrameCount& unknown{tally_.with(FrameStatus::road_unknown)};
    const FrameCount& missed{tally_.without_road};
    const bool is_single{missed.frames == 1 && tally_.frames > 1};
    const bool is_missed{context_.config.ground.estimate && !is_single && every * missed.frames >= tally_.frames};
    if (missed.frames == 0 || (!is_missed && unknown.frames == 0)) return;
    const auto frame{context_.frame_at(missed.first.index)};
    const bool is_below{has_any(missed.first.status, {FrameStatus::extrinsics_disagree})};  // the ground in view
    if (const auto fault{frame && !is_below ? fault_if_upside_down(*frame, context_) : std::nullopt})
      return say(*fault);
    if (const std::string fault{frame ? fault_of_scale(*frame, context_) : ""}; !fault.empty()) return say(fault);
    if (const auto fault{frame ? fault_of_view(*frame, context_) : std::nullopt}) return say(*fault);
    if (const auto fault{frame ? fault_of_residual(*frame) : std::nullopt}) return say(*fault);
    std::string text{fmt::format("road not found in {} (first: {})", share(missed), missed.first.name)};
    if (unknown.frames > 0) {
      text += fmt::format("; in {} the ground plane is unknown, and so is the grid", share(unknown));
    }
    const bool is_explained{unknown.frames > 0 && context_.used == context_.source_rig};
    text += is_explained ? ": " + text_of(unknown.first, FrameStatus::road_unknown) : advice_on_extrinsics();
    say(text + warning_of_baseline());
  }

  [[nodiscard]] std::string warning_of_baseline() const {
    constexpr double narrowest_m{0.02};
    constexpr double widest_m{1};  // stereo cameras of cars
    const double baseline_m{context_.source_rig.baseline_m};
    if (baseline_m >= narrowest_m && baseline_m <= widest_m) return "";
    return fmt::format(" The baseline of {:.4g} m is unusual ({} to {} m): check its unit.", baseline_m, narrowest_m,
                       widest_m);
  }

  [[nodiscard]] std::string advice_on_extrinsics() const {
    const Rig& rig{context_.source_rig};
    if (context_.used != rig) {
      return fmt::format(
          ". The calibration has no extrinsics: a run estimates them where ground is in plain view. Grids before are "
          "unknown. For calibration.yaml: {}",
          io::mount_line(context_.used));
    }
    return fmt::format(
        ". It may be out of view, wet, without texture or a slope, or the extrinsics in the calibration may be wrong: "
        "{:.3g} m above the road and a pitch of {:.1f}° (down). Measure them, and give mount.camera_height_m and "
        "mount.camera_pitch_rad.",
        rig.camera_height_m, rig.camera_pitch_rad * degrees);
  }

  void report_pitch() {
    constexpr double noticeable_deg{2};
    const double given_rad{context_.source_rig.camera_pitch_rad};
    if (tally_.road_pitches.empty() || context_.used != context_.source_rig) return;
    const double pitch_rad{median_pitch_rad(tally_) + given_rad -
                           LevelMapping{context_.used}.level_rig().camera_pitch_rad};
    if (std::abs(pitch_rad - given_rad) * degrees <= noticeable_deg) return;
    say(
        fmt::format("camera pitch {:.1f}° (calibration: {:.1f}°). Results are better with "
                    "mount.camera_pitch_rad: {:.3f} in the calibration.",
                    pitch_rad * degrees, given_rad * degrees, pitch_rad));
  }

  // Without mount, nothing but the baseline gives the scene its scale.
  void report_height() {
    constexpr double low_m{0.2};
    constexpr double high_m{3};
    const double height_m{context_.used.camera_height_m};
    if (context_.used == context_.source_rig || (height_m >= low_m && height_m <= high_m)) return;
    say(fmt::format(
        "the estimated height of the camera is {:.2f} m, which few vehicles have: is the baseline {:.4g} m, "
        "in metres, that of this pair? All distances are scaled by it. If both are right, give: {}",
        height_m, context_.source_rig.baseline_m, io::mount_line(context_.used)));
  }

  // The lowest rows show the nearest ground, at d = (b/h)·(f·sin(pitch) + (rows below the centre)·cos(pitch)).
  void report_near_ground() {
    constexpr double farther{1.25};  // than the nearest ground in view
    const Rig& rig{context_.used};
    const int disparities{context_.config.matching.disparities};
    const double lowest{rig.focal_px * std::sin(rig.camera_pitch_rad) +
                        (rig.height_px - 1 - rig.cy_px) * std::cos(rig.camera_pitch_rad)};
    const double needed{rig.baseline_m / rig.camera_height_m * lowest + 1};
    if (disparities == 0 || !(needed > farther * disparities)) return;
    const double from_m{rig.focal_px * rig.baseline_m / (disparities - 1)};
    say(fmt::format(
        "matching.disparities {} is too small for the nearest ground, which needs {:.0f}: ground is known from "
        "{:.2f} m on. Leave matching.disparities out, or set it to {:.0f}.",
        disparities, needed, from_m, 32 * std::ceil(needed / 32)));
  }

  void report_unknown_grids() {
    const std::size_t unknown{tally_.unknown.frames};
    if (2 * unknown <= tally_.frames) return;
    say(fmt::format("most grids are unknown: those of {} ({:.0f} %).", share(tally_.unknown),
                    100.0 * static_cast<double>(unknown) / static_cast<double>(tally_.frames)));
  }

  const FrameTally& tally_;
  const TallyContext& context_;
  Findings findings_;
};

}  // namespace

bool shows_road(const io::FrameSummary& frame) {
  return frame.ground.estimated && !has_any(frame.status, {FrameStatus::few_matches, FrameStatus::road_unknown});
}

void FrameTally::add(const io::FrameSummary& frame) {
  ++frames;
  if (!frame.is_known) unknown.add(frame);
  for (const FrameStatus flag : frame.status) flags[static_cast<std::size_t>(flag)].add(frame);
  if (frame.exposure_warning) unequal_exposure.add(frame);
  if (shows_road(frame)) {
    ++road_pitches[static_cast<int>(std::lround(frame.ground.pitch_rad / pitch_step_rad))];
  } else if (!has_any(frame.status, {FrameStatus::few_matches})) {
    without_road.add(frame);
  }
}

Findings findings_of(const FrameTally& tally, const TallyContext& context) {
  return DriveDiagnosis{tally, context}.diagnose();
}

}  // namespace stereogrid::app
