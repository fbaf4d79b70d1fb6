// SPDX-License-Identifier: Apache-2.0
#include "diagnostics/own_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "stereogrid/points.hpp"

namespace stereogrid::app {
namespace {

constexpr int step_px{4};
constexpr double step_m{0.5};  // between two frames that count
constexpr std::size_t frames_min{20};
constexpr double travelled_min_m{20};
// Textured samples, and the share of them that changes after step_m; of a static scene a tenth at most.
constexpr int textured_grey{8};
constexpr double changed_min{0.4};
// Tolerance of the vehicle's disparity, constant in all but a few frames.
constexpr float steady_px{1};
constexpr float steady_share{0.03F};
constexpr double always{0.9};
constexpr double seen_min{0.3};
constexpr double farthest_m{5};
constexpr double lowest_m{0.15};
// Minimum share of the frames in which the street's texture changes; the vehicle's changes in fewer.
constexpr double street_changes_min{0.2};
constexpr double vehicle_changes_max{0.1};
// Minimum shares of the pixels below the outline that are seen as the vehicle, in a column and in total by disparity,
// and minimum width of the outline.
constexpr double filled_min{0.3};
constexpr double steady_min{0.15};
constexpr double width_min{0.1};

int gradient_at(const Image<std::uint8_t>& image, int u, int v) {
  if (u < 1 || u + 1 >= image.width()) return 0;
  return image(u + 1, v) - image(u - 1, v);
}

bool is_known(const FrameResult& result) {
  return !has_any(result.status, {FrameStatus::road_unknown, FrameStatus::few_matches, FrameStatus::pose_missing,
                                  FrameStatus::pose_jump});
}

std::vector<int> medians(const std::vector<int>& values) {
  constexpr std::ptrdiff_t reach{4};
  std::vector<int> smooth;
  for (auto at = values.begin(); at != values.end(); ++at) {
    std::vector<int> around{at - std::min(reach, at - values.begin()), at + std::min(reach + 1, values.end() - at)};
    const auto middle{around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2)};
    std::ranges::nth_element(around, middle);
    smooth.push_back(*middle);
  }
  return smooth;
}

}  // namespace

void OwnVehicle::begin(const Rig& rig) {
  rig_ = rig;
  mapping_ = LevelMapping{rig};
  across_ = mapping_.level_rig().width_px / step_px;
  down_ = mapping_.level_rig().height_px / step_px;
  places_.clear();
  for (int j{0}; j < down_; ++j) {
    for (int i{0}; i < across_; ++i) {
      const int u{i * step_px + step_px / 2};
      const int v{j * step_px + step_px / 2};
      const auto camera{mapping_.camera_from_level({static_cast<double>(u), static_cast<double>(v)})};
      const int camera_u{camera ? static_cast<int>(std::lround(camera->u)) : 0};
      const int camera_v{camera ? static_cast<int>(std::lround(camera->v)) : -1};
      const bool is_inside{camera_v >= 0 && camera_v < rig.height_px};
      places_.push_back({u, v, camera_u, is_inside ? camera_v : -1, 0, {}, 0, 0, 0});
    }
  }
  has_frame_ = false;
  frames_ = 0;
  travelled_m_ = 0;
}

void OwnVehicle::add(const StereoFrame& frame, const FrameResult& result) {
  if (result.rig != rig_) begin(result.rig);
  if (!is_known(result) || result.stages.obstacle_disparity.width() != mapping_.level_rig().width_px) return;
  const Pose2& pose{result.world_from_vehicle};
  const double moved_m{std::hypot(pose.x_m - last_pose_.x_m, pose.y_m - last_pose_.y_m)};
  if (has_frame_ && (moved_m < step_m || !has_moved(frame))) return;
  if (has_frame_) travelled_m_ += moved_m;
  has_frame_ = true;
  last_pose_ = pose;
  count(frame, result);
}

// True if the textured samples of the image have changed.
bool OwnVehicle::has_moved(const StereoFrame& frame) const {
  int textured{0};
  int changed{0};
  for (const Place& place : places_) {
    if (std::abs(place.gradient) < textured_grey) continue;
    const int now{gradient_at(frame.left, place.camera_u, place.camera_v)};
    ++textured;
    changed += 2 * std::abs(now - place.gradient) > std::abs(place.gradient) ? 1 : 0;
  }
  return textured > 0 && changed >= changed_min * textured;
}

void OwnVehicle::count(const StereoFrame& frame, const FrameResult& result) {
  ++frames_;
  for (Place& place : places_) {
    const int gradient{place.camera_v < 0 ? 0 : gradient_at(frame.left, place.camera_u, place.camera_v)};
    const int limit{std::max(textured_grey, std::abs(place.gradient) / 2)};
    place.changed += frames_ > 1 && std::abs(gradient - place.gradient) > limit ? 1 : 0;
    place.textured += std::abs(gradient) >= textured_grey ? 1 : 0;
    place.gradient = gradient;
  }
  // the points come in the order of the pixels that have a disparity
  const std::vector<LabelledPoint> points{points_of(result, mapping_.level_rig())};
  const StageImages& stages{result.stages};
  auto point = points.begin();
  for (int v{0}; v < stages.obstacle_disparity.height(); ++v) {
    for (int u{0}; u < stages.obstacle_disparity.width() && point != points.end(); ++u) {
      const float disparity{std::max(stages.obstacle_disparity(u, v), stages.road_disparity(u, v))};
      if (!(disparity > 0)) continue;
      const LabelledPoint& here{*point++};
      if (u % step_px != step_px / 2 || v % step_px != step_px / 2 || u / step_px >= across_ || v / step_px >= down_) {
        continue;
      }
      Place& place{places_[static_cast<std::size_t>(v / step_px * across_ + u / step_px)]};
      place.seen.push_back(disparity);
      place.off_the_road += std::hypot(here.x_m, here.y_m) < farthest_m && here.z_m > lowest_m ? 1 : 0;
    }
  }
}

bool OwnVehicle::is_sure() const {
  return frames_ >= frames_min && travelled_m_ >= travelled_min_m;
}

OwnVehicle::Verdict OwnVehicle::verdict_of(const Place& place) const {
  const auto seen{static_cast<double>(place.seen.size())};
  const auto all{static_cast<double>(frames_)};
  if (seen >= seen_min * all && static_cast<double>(place.off_the_road) >= always * seen) {
    std::vector<float> sorted{place.seen};
    const auto middle{sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2)};
    std::ranges::nth_element(sorted, middle);
    const float usual{*middle};
    const float reach{std::max(steady_px, steady_share * usual)};
    const auto steady{std::ranges::count_if(sorted, [&](float d) { return std::abs(d - usual) <= reach; })};
    if (static_cast<double>(steady) >= always * seen) return Verdict::steady;
  }
  const auto changed{static_cast<double>(place.changed)};
  if (changed >= street_changes_min * all) return Verdict::street;
  const bool is_still{changed <= vehicle_changes_max * all && static_cast<double>(place.textured) >= always * all};
  return is_still ? Verdict::still : Verdict::unknown;
}

// From the lower edge to where the street is twice in a row.
OwnVehicle::Column OwnVehicle::look_up(int column) const {
  Column found{down_, 0, -1};
  int vehicle{0};
  int street{0};
  for (int j{down_ - 1}; j >= 0 && street < 2; --j) {
    const Verdict verdict{verdict_of(places_[static_cast<std::size_t>(j * across_ + column)])};
    if (verdict == Verdict::street) found.lowest_street = std::max(found.lowest_street, j);
    street = verdict == Verdict::street ? street + 1 : 0;
    found.steady += verdict == Verdict::steady ? 1 : 0;
    if (verdict != Verdict::steady && verdict != Verdict::still) continue;
    ++vehicle;
    if (vehicle >= filled_min * (down_ - j)) found.top = j;
  }
  return found;
}

// Row in which the vehicle begins, for each column of samples; `down_`: no vehicle. Columns without evidence (paint
// without texture, the left edge outside of the right image) continue their neighbour's outline below the street.
std::vector<int> OwnVehicle::outline() const {
  std::vector<Column> columns;
  for (int i{0}; i < across_; ++i) columns.push_back(look_up(i));
  const auto carry_on = [this](const Column& neighbour, Column& column) {
    if (column.top == down_) column.top = std::max(neighbour.top, column.lowest_street + 1);
  };
  for (std::size_t i{1}; i < columns.size(); ++i) carry_on(columns[i - 1], columns[i]);
  for (std::size_t i{columns.size()}; i-- > 1;) carry_on(columns[i], columns[i - 1]);
  std::vector<int> tops;
  int steady{0};
  int covered{0};
  for (const Column& column : columns) {
    tops.push_back(column.top);
    steady += column.steady;
    covered += down_ - column.top;
  }
  if (steady < steady_min * covered) return std::vector<int>(columns.size(), down_);
  return medians(tops);
}

Image<std::uint8_t> OwnVehicle::mask(int margin_px) const {
  if (!is_sure()) return {};
  const std::vector<int> tops{outline()};
  const auto wide{std::ranges::count_if(tops, [&](int top) { return top < down_; })};
  if (static_cast<double>(wide) < width_min * across_) return {};
  Image<std::uint8_t> mask{rig_.width_px, rig_.height_px, 255};
  for (int v{0}; v < mask.height(); ++v) {
    for (int u{0}; u < mask.width(); ++u) {
      const auto level{mapping_.level_from_camera({static_cast<double>(u), static_cast<double>(v)})};
      if (!level) continue;
      const int i{std::clamp(static_cast<int>(level->u) / step_px, 0, across_ - 1)};
      const int top{tops[static_cast<std::size_t>(i)]};
      if (top < down_ && level->v >= top * step_px - margin_px) mask(u, v) = 0;
    }
  }
  return mask;
}

}  // namespace stereogrid::app
