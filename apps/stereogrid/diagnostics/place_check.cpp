// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnostics/frame_tally.hpp"

namespace stereogrid::app {
namespace {

constexpr double degree_rad{0.017453292519943295};
constexpr int compared_frames_max{20};
constexpr double compared_within_m{15};  // depths beyond it are uncertain
constexpr double turn_step_rad{0.5 * degree_rad};
constexpr float cell_log_odds_max{3.5F};
// Pairs whose places are right stay below one of them (docs/decisions.md, 35).
constexpr double turn_min_rad{2.25 * degree_rad};
constexpr int compared_frames_min{3};
constexpr double compared_cells_min{400};    // in a frame
constexpr double compared_obstacles_min{5};  // likewise; ground alone has no places
constexpr double overlap_min_rad{24.5 * degree_rad};
constexpr double agreement_gain_min{12};  // gain of the correlation, times these cells

/// 0: unknown.
Image<float> log_odds_of(const Image<float>& occupancy) {
  Image<float> made{occupancy.width(), occupancy.height()};
  std::ranges::transform(occupancy, made.begin(), [](float p) {
    return p == 0.5F ? 0.0F : std::clamp(std::log(p / (1 - p)), -cell_log_odds_max, cell_log_odds_max);
  });
  return made;
}

/// Angle that both cameras see.
double overlap_rad(const Rig& one, const Rig& other) {
  const double turned_rad{std::remainder(one.camera_yaw_rad - other.camera_yaw_rad, 360 * degree_rad)};
  const HorizontalView first{horizontal_view(one)};
  const HorizontalView second{horizontal_view(other)};
  return std::min(first.left_rad + turned_rad, second.left_rad) -
         std::max(first.right_rad + turned_rad, second.right_rad);
}

double turn_rad(std::size_t turn, int turns) {
  return (static_cast<double>(turn) - turns / 2) * turn_step_rad;
}

}  // namespace

double PlaceCheck::Agreement::correlation() const {
  return cells == 0 ? 0 : product / std::sqrt(first * second);
}

void PlaceCheck::compare(const Image<float>& first, const Image<float>& second, const GridGeometry& grid,
                         const Pose2& place, Turned& turned) {
  std::array<Pose2, turns_> original_from_turned;
  for (std::size_t turn{0}; turn < turned.size(); ++turn)
    original_from_turned[turn] = Pose2{place.x_m, place.y_m, -turn_rad(turn, turns_)};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const double a{first(ix, iy)};
      const Point2 centre{grid.centre(ix, iy)};
      const Point2 from_camera{centre.x - place.x_m, centre.y - place.y_m};
      if (a == 0 || std::hypot(from_camera.x, from_camera.y) > compared_within_m) continue;
      for (std::size_t turn{0}; turn < turned.size(); ++turn) {
        const auto cell{grid.cell_at(original_from_turned[turn] * from_camera)};
        const double b{cell ? second(cell->ix, cell->iy) : 0.0F};
        if (b == 0) continue;
        Agreement& sums{turned[turn]};
        sums.product += a * b;
        sums.first += a * a;
        sums.second += b * b;
        ++sums.cells;
        sums.obstacles += a > 0 && b > 0 ? 1 : 0;
      }
    }
  }
}

void PlaceCheck::add(const FrameResult& result) {
  const std::vector<FrameResult>& cameras{result.cameras};
  if (cameras.size() < 2 || frames_ == compared_frames_max || seen_++ % every_ != 0) return;
  ++frames_;
  names_.clear();
  std::vector<Image<float>> log_odds;
  for (const FrameResult& camera : cameras) {
    names_.push_back(camera.camera_name);
    log_odds.push_back(log_odds_of(camera.observed));
  }
  for (std::size_t i{0}; i < cameras.size(); ++i) {
    for (std::size_t j{i + 1}; j < cameras.size(); ++j) {
      if (overlap_rad(cameras[i].rig, cameras[j].rig) < overlap_min_rad) continue;
      compare(log_odds[i], log_odds[j], result.vehicle.geometry, camera_place(cameras[j].rig), pairs_[{i, j}]);
    }
  }
}

std::vector<std::string> PlaceCheck::findings() const {
  std::vector<std::string> texts;
  if (frames_ < compared_frames_min) return texts;
  for (const auto& [pair, turned] : pairs_) {
    const Agreement& as_placed{turned[turns_ / 2]};
    const double cells{static_cast<double>(as_placed.cells) / frames_};
    std::size_t best{turns_ / 2};
    for (std::size_t turn{0}; turn < turned.size(); ++turn) {
      if (2 * turned[turn].cells > as_placed.cells && turned[turn].correlation() > turned[best].correlation())
        best = turn;
    }
    const double turn{turn_rad(best, turns_)};
    const double gain{(turned[best].correlation() - as_placed.correlation()) * cells};
    const bool is_at_end{best == 0 || best + 1 == turned.size()};
    if (is_at_end || std::abs(turn) < turn_min_rad || cells < compared_cells_min || gain < agreement_gain_min) continue;
    if (turned[best].obstacles < compared_obstacles_min * frames_) continue;
    texts.push_back(fmt::format(
        "{} and {}: where both see, their grids agree better with {} turned by {:+.1f}°. Check camera_yaw_rad, "
        "camera_x_m and camera_y_m in the mount of both.",
        names_[pair.first], names_[pair.second], names_[pair.second], turn / degree_rad));
  }
  return texts;
}

}  // namespace stereogrid::app
