// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0

#include "truth_cells.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr std::int64_t seen_from_pixels{100};
constexpr double occupied_from{0.5};

struct Mean {
  double sum{0};
  double cells{0};
};

/// Mean p over the cells below each object.
std::map<std::int64_t, Mean> means_by_object(const MotionFrame& frame) {
  std::map<std::int64_t, Mean> means;
  for_shared_cells(frame, [&](int tx, int ty, int ix, int iy) {
    if (frame.truth.occupied(tx, ty) == 0) return;
    Mean& mean{means[frame.truth.owner(tx, ty)]};
    mean.sum += static_cast<double>(frame.occupancy(ix, iy));
    mean.cells += 1;
  });
  return means;
}

/// Its place lies within the image's columns, so that only other things can hide it.
bool is_ahead(const MotionFrame& frame, const TruthObject& object) {
  const Point2 place{inverse(frame.truth.ego.world_from_vehicle) *
                     Point2{object.world_from_object.x_m, object.world_from_object.y_m}};
  if (place.x <= 0) return false;
  const double u{frame.rig.cx_px - frame.rig.focal_px * place.y / place.x};
  return u >= 0 && u < frame.rig.width_px;
}

}  // namespace

void HiddenSurvival::add(const MotionFrame& frame) {
  const std::map<std::int64_t, Mean> means{means_by_object(frame)};
  for (const TruthObject& object : frame.truth.objects) {
    if (object.pixels >= seen_from_pixels) seen_.insert(object.id);
    const auto mean{means.find(object.id)};
    const bool hidden{object.pixels == 0 && seen_.contains(object.id) && is_ahead(frame, object)};
    if (hidden && mean != means.end()) {
      extend(object.id, frame.truth.stamp_ns, mean->second.sum / mean->second.cells);
    } else {
      close(object.id);
    }
  }
}

void HiddenSurvival::extend(std::int64_t id, std::int64_t stamp_ns, double mean) {
  Open& open{open_.try_emplace(id, Open{stamp_ns, stamp_ns, std::nullopt, {}}).first->second};
  open.last_ns = stamp_ns;
  ++open.counts.frames;
  if (mean >= occupied_from) {
    ++open.counts.alive;
  } else if (!open.lost_ns) {
    open.lost_ns = stamp_ns;
  }
}

void HiddenSurvival::close(std::int64_t id) {
  const auto found{open_.find(id)};
  if (found == open_.end()) return;
  const Open& open{found->second};
  Episode episode{open.counts};
  episode.hidden_s = static_cast<double>(open.last_ns - open.since_ns) * 1e-9;
  episode.survived_s = static_cast<double>(open.lost_ns.value_or(open.last_ns) - open.since_ns) * 1e-9;
  finished_.push_back(episode);
  open_.erase(found);
}

std::vector<HiddenSurvival::Episode> HiddenSurvival::episodes() const {
  HiddenSurvival ended{*this};
  for (const auto& [id, open] : open_) ended.close(id);
  return ended.finished_;
}

}  // namespace stereogrid::evaluation
