// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::capture {
namespace {

using namespace std::chrono_literals;

constexpr auto poll_every{1ms};
constexpr std::chrono::milliseconds silence{2000};    // until a camera without a frame has stopped; longest interval
constexpr int missed_max{3};                          // intervals without a frame, after which a camera has stopped
constexpr std::int64_t assumed_step_ns{100'000'000};  // interval before the second frame
constexpr std::size_t frames_kept{4};                 // frames of a camera

/// A stereo pair, with the frames that are in no set yet.
struct Member {
  struct Waiting {
    LiveFrame live;
    Clock::time_point arrived;
  };

  std::string name;
  std::unique_ptr<LiveSource> source;
  std::deque<Waiting> waiting{};                // stamps grow
  std::optional<std::int64_t> newest_ns{};      // the last frame's
  std::int64_t step_ns{assumed_step_ns};        // between its last two stamps
  Clock::time_point arrived{Clock::now()};      // arrival of the last frame
  Clock::duration pause{silence / missed_max};  // between its last two frames: arrivals or stamps, the longer one
  Clock::time_point used{Clock::now()};         // its last frame in a set

  void add(LiveFrame live);
  [[nodiscard]] bool has_stopped() const { return Clock::now() - arrived > missed_max * pause; }
  [[nodiscard]] bool may_give(std::int64_t stamp_ns, std::int64_t tolerance_ns) const;
  /// The waiting frame nearest to an instant, if it is no farther away than that; earlier ones are removed.
  [[nodiscard]] std::optional<StereoFrame> pop_nearest(std::int64_t stamp_ns, std::int64_t tolerance_ns);
};

void Member::add(LiveFrame live) {
  const Clock::time_point now{Clock::now()};
  const std::int64_t stamp_ns{live.frame.stamp_ns};
  if (newest_ns && stamp_ns <= *newest_ns) return;
  if (newest_ns) {
    step_ns = stamp_ns - *newest_ns;
    pause =
        std::min<Clock::duration>(silence, std::max<Clock::duration>(now - arrived, std::chrono::nanoseconds{step_ns}));
  }
  if (!newest_ns) used = now;
  newest_ns = stamp_ns;
  arrived = now;
  waiting.push_back({std::move(live), now});
}

/// True if a frame within `tolerance_ns` of that instant, or before it, is expected.
bool Member::may_give(std::int64_t stamp_ns, std::int64_t tolerance_ns) const {
  if (!newest_ns || *newest_ns >= stamp_ns || has_stopped()) return false;
  if (stamp_ns - *newest_ns > missed_max * step_ns) return false;  // lost, or of another clock
  return *newest_ns + step_ns - stamp_ns <= tolerance_ns;
}

std::optional<StereoFrame> Member::pop_nearest(std::int64_t stamp_ns, std::int64_t tolerance_ns) {
  const auto away_ns = [&](const Waiting& one) { return std::abs(one.live.frame.stamp_ns - stamp_ns); };
  const auto nearest{std::ranges::min_element(waiting, {}, away_ns)};
  std::optional<StereoFrame> frame;
  if (nearest != waiting.end() && away_ns(*nearest) <= tolerance_ns) {
    frame = std::move(nearest->live.frame);
    used = Clock::now();
    waiting.erase(waiting.begin(), std::next(nearest));
  }
  return frame;
}

/// Sets of frames of several stereo pairs, as Recording::add_camera() makes them. The set has the stamp of the first
/// camera that has not stopped.
class CameraSet final : public LiveSource {
 public:
  explicit CameraSet(std::vector<NamedSource> cameras) {
    for (const NamedSource& camera : cameras) names_.push_back(camera.name);
    names_ = io::camera_names(names_);
    for (std::size_t i{0}; i < cameras.size(); ++i) {
      rigs_.push_back(cameras[i].source->rig());
      members_.push_back({.name = names_[i], .source = std::move(cameras[i].source)});
    }
  }

  [[nodiscard]] const Rig& rig() const override { return rigs_.front(); }
  [[nodiscard]] std::span<const Rig> rigs() const override { return rigs_; }
  [[nodiscard]] std::vector<std::string> camera_names() const override { return names_; }
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds patience) override;
  [[nodiscard]] bool has_ended() const override {
    return std::ranges::all_of(members_, [](const Member& one) { return one.source->has_ended(); });
  }
  [[nodiscard]] std::string fault() const override;
  [[nodiscard]] std::vector<Drop> dropped() const override;

 private:
  void receive(Member& member);
  void restart();
  [[nodiscard]] Member* leader();
  [[nodiscard]] std::optional<LiveFrame> make_set();
  [[nodiscard]] bool waits_for(const Member& member, const Member& first) const;
  void find_other_clocks(const Member& first);

  std::vector<std::string> names_;
  std::vector<Rig> rigs_;
  std::vector<Member> members_;  // for next(); sources and names for all
  std::optional<std::int64_t> last_ns_;
  bool resets_before_{false};
  std::int64_t sets_{0};
  std::atomic<std::int64_t> unused_{0};

  mutable std::mutex mutex_;  // protects the member below
  std::string other_clocks_;
};

[[nodiscard]] std::int64_t tolerance_ns(const Member& one, const Member& other) {
  return std::min(one.step_ns, other.step_ns) / 2;
}

std::optional<LiveFrame> CameraSet::next(std::chrono::milliseconds patience) {
  const auto until{Clock::now() + patience};
  for (;;) {
    for (Member& member : members_) receive(member);
    if (auto set{make_set()}) return set;
    if (Clock::now() >= until) return std::nullopt;
    std::this_thread::sleep_for(poll_every);
  }
}

void CameraSet::receive(Member& member) {
  try {
    std::optional<LiveFrame> live{member.source->next(0ms)};
    if (!live) return;
    if (live->resets_before) restart();
    member.add(*std::move(live));
  } catch (const InputError& error) {
    throw InputError{fmt::format("{}: {}", member.name, error.what())};
  }
  if (member.waiting.size() <= frames_kept) return;
  member.waiting.pop_front();
  ++unused_;
}

void CameraSet::restart() {
  for (Member& member : members_) {
    member.waiting.clear();
    member.newest_ns.reset();
  }
  last_ns_.reset();
  resets_before_ = true;
}

/// The first camera that has not stopped, once it has a frame; nullptr: it has none.
Member* CameraSet::leader() {
  for (Member& member : members_) {
    if (!member.waiting.empty()) return &member;
    if (!member.has_stopped()) return nullptr;
  }
  return nullptr;
}

bool CameraSet::waits_for(const Member& member, const Member& first) const {
  const Member::Waiting& oldest{first.waiting.front()};
  return &member != &first && Clock::now() - oldest.arrived < member.pause &&
         member.may_give(oldest.live.frame.stamp_ns, tolerance_ns(member, first));
}

std::optional<LiveFrame> CameraSet::make_set() {
  Member* const first{leader()};
  if (first == nullptr) return std::nullopt;
  if (std::ranges::any_of(members_, [&](const Member& one) { return waits_for(one, *first); })) return std::nullopt;
  LiveFrame set{std::move(first->waiting.front().live)};
  first->waiting.pop_front();
  first->used = Clock::now();
  const std::int64_t stamp_ns{set.frame.stamp_ns};
  if (last_ns_ && stamp_ns <= *last_ns_) {
    if (*last_ns_ - stamp_ns <= std::chrono::nanoseconds{silence}.count()) {
      ++unused_;
      return std::nullopt;
    }
    resets_before_ = true;  // the sets before had the stamps of a camera with another clock
  }
  last_ns_ = stamp_ns;
  StereoFrame own{std::move(set.frame)};
  set.frame = {};
  set.frame.stamp_ns = stamp_ns;
  set.frame.world_from_vehicle = own.world_from_vehicle;
  for (std::size_t i{0}; i < members_.size(); ++i) {
    Member& member{members_[i]};
    const std::size_t waiting{member.waiting.size()};
    std::optional<StereoFrame> frame{&member == first ? std::optional{std::move(own)}
                                                      : member.pop_nearest(stamp_ns, tolerance_ns(member, *first))};
    if (!frame) continue;
    if (&member != first) unused_ += static_cast<std::int64_t>(waiting - member.waiting.size()) - 1;
    frame->camera = static_cast<int>(i);
    i == 0 ? set.frame = *std::move(frame) : set.frame.others.emplace_back(*std::move(frame));
  }
  set.frame.index = sets_++;
  set.frame.name = fmt::format("{:06}", set.frame.index);
  set.resets_before = std::exchange(resets_before_, false);
  find_other_clocks(*first);
  return set;
}

/// Names a camera whose frames are never near those of the first one.
void CameraSet::find_other_clocks(const Member& first) {
  std::string text;
  for (const Member& member : members_) {
    if (!member.newest_ns || member.has_stopped() || Clock::now() - member.used <= silence) continue;
    text = fmt::format(
        "{}: its stamps are {:+.1f} s from those of {}, so that it observes nothing. Give the cameras one "
        "clock.",
        member.name, 1e-9 * static_cast<double>(*member.newest_ns - *first.newest_ns), first.name);
  }
  const std::scoped_lock lock{mutex_};
  other_clocks_ = std::move(text);
}

std::string CameraSet::fault() const {
  for (const Member& member : members_) {
    if (const std::string text{member.source->fault()}; !text.empty()) return fmt::format("{}: {}", member.name, text);
  }
  const std::scoped_lock lock{mutex_};
  return other_clocks_;
}

std::vector<Drop> CameraSet::dropped() const {
  std::vector<Drop> drops;
  for (const Member& member : members_) {
    for (const Drop& drop : member.source->dropped())
      drops.push_back({fmt::format("{}: {}", member.name, drop.reason), drop.frames});
  }
  if (unused_ > 0) drops.push_back({"no frame of the first camera beside it", unused_});
  return drops;
}

}  // namespace

std::unique_ptr<LiveSource> join_cameras(std::vector<NamedSource> cameras) {
  if (cameras.size() == 1) return std::move(cameras.front().source);
  return std::make_unique<CameraSet>(std::move(cameras));
}

}  // namespace stereogrid::capture
