// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <span>

#include "filter/evidence.hpp"
#include "filter/filter.hpp"
#include "filter/held_cell.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "matching/mask.hpp"
#include "matching/matches.hpp"
#include "pipeline/saved_state.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid {

/// A frame as the stages take it: level images that fit the rig.
struct LevelFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;
  View<const float> disparity;  ///< given instead of the right image; empty: match
  Pose2 world_from_vehicle;
  double dt_s{0};
  std::span<const ObservedGrid> other_grids;
  CameraView view{};
  bool is_ahead{false};  ///< the images are those of the last take_ahead()

  [[nodiscard]] bool is_given() const { return !disparity.empty(); }
};

/// What FrameProcessor does of a frame without asking the host in between.
enum class StagePart { match, grids, unknown_grids };

/// Threads for what the host does itself.
class HostThreads {
 public:
  virtual ~HostThreads() = default;
  [[nodiscard]] virtual int count() const = 0;
  /// See Stages.
  virtual void for_ranges(int count, const std::function<void(int, int)>& work) = 0;
  virtual void together(const std::function<void()>& first, const std::function<void()>& second) = 0;
};

/// The stages as one back end does them, and the images that they hand to each other. In which order, and what is
/// decided between them, is FrameProcessor's.
class Stages {
 public:
  Stages() = default;
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;
  virtual ~Stages() = default;

  // What the stages of a frame work on.

  /// `window`: where the filter's grid lies now. What `frame` views and `result` must stay until finish(). On the first
  /// frame nothing is remembered.
  virtual void begin(const LevelFrame& frame, const GridGeometry& window, bool is_first, FrameResult& result) = 0;
  /// Before match(). `expected`: where the road hypothesis takes the road to be; `previous`: where it was in the frame
  /// before.
  virtual void expect(const Ground& expected, const Ground& previous, const RowAlignment& rows) = 0;
  /// By ascending cell, one for a cell; none at the beginning of a frame.
  virtual void take_velocities(std::span<const VelocityEvidence> evidence) = 0;
  /// Cells, each once, at most held_cells_max, that fuse() leaves occupied in the window; none at the beginning of a
  /// frame. They must stay until finish().
  virtual void hold(std::span<const HeldCell> cells) = 0;

  // The stages, to be called within perform().

  virtual void match() = 0;
  virtual void estimate_ground() = 0;
  virtual void count() = 0;
  virtual void project() = 0;
  /// Instead of count() and project().
  virtual void observe_nothing() = 0;
  virtual void fuse() = 0;
  virtual void filter() = 0;
  virtual void weigh_velocities() = 0;
  virtual void resample() = 0;

  /// Does `work`: calls of the stages above, for each part the same ones in every frame, which a device may record and
  /// repeat.
  virtual void perform(StagePart /*part*/, const std::function<void()>& work) { work(); }
  /// Goes on while the host decides: what it is then given to do twice, counts the second time.
  [[nodiscard]] virtual bool works_ahead() const { return false; }

  // What was found.

  /// The plane from estimate_ground().
  virtual Ground ground() = 0;
  /// Do the matches have the road clearly elsewhere than expected? Known after estimate_ground().
  virtual bool is_lost() = 0;
  /// Valid at the pixels of MatchLattice only.
  virtual const Matches& matches_on_lattice() = 0;
  /// All pixels. Given disparities are not split into road and obstacle.
  virtual const Matches& unsplit_matches() = 0;
  /// (H, W) px, 0 = none. Known after estimate_ground().
  virtual View<const float> obstacle_disparity() = 0;
  /// Before finish(), when nothing more will be asked of the matches: the images that the next frame may begin with.
  /// A device can have them while it still works on this frame.
  virtual void take_ahead(View<const std::uint8_t> /*left*/, View<const std::uint8_t> /*right*/) {}
  /// Fills the result's grids, densities, the times of the stages and, where they are wanted, FrameResult::stages.
  virtual void finish() = 0;

  // Of the back end.

  /// For a back end that has no threads of the host itself. They must stay.
  void lend(HostThreads& threads) { lent_ = &threads; }
  /// Of the host.
  [[nodiscard]] virtual int threads() const { return lent_ != nullptr ? lent_->count() : 1; }
  /// Calls work(begin, end) on parts of [0, count), on the host.
  virtual void for_ranges(int count, const std::function<void(int, int)>& work) {
    lent_ != nullptr ? lent_->for_ranges(count, work) : work(0, count);
  }
  /// Calls both on the host, at the same time where there are threads for it; they must not disturb each other.
  virtual void together(const std::function<void()>& first, const std::function<void()>& second) {
    if (lent_ != nullptr) return lent_->together(first, second);
    first();
    second();
  }
  virtual void fetch_stages(bool wanted) = 0;
  /// A result that nobody else changes: what stays the same in it from frame to frame need not be written again.
  virtual void keep(const FrameResult& /*result*/) {}
  /// Before the first frame, once: pixels without disparities in all frames. It stays.
  virtual void take_mask(const PixelMask& mask) = 0;
  [[nodiscard]] virtual MemoryUse memory_use() const = 0;
  /// What the filter remembers.
  virtual void save(StateWriter& state) = 0;
  virtual void load(StateReader& state) = 0;
  /// To be called before predict().
  virtual void make_room_for_predictions() {}
  /// Fills result.predictions after finish().
  virtual void predict(const Pose2& /*world_from_vehicle*/, FrameResult& /*result*/) {}

 private:
  HostThreads* lent_{nullptr};
};

std::unique_ptr<Stages> cpu_stages(const Config& config, const Rig& level_rig, int threads);
std::unique_ptr<Stages> reference_stages(const Config& config, const Rig& level_rig);

}  // namespace stereogrid
