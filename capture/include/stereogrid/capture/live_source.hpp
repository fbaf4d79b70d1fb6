// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::capture {

/// Clock of instants within this process; capture times of cameras are converted to it.
using Clock = std::chrono::steady_clock;

/// A rectified frame that has just been captured. Its stamp is Unix time.
struct LiveFrame {
  StereoFrame frame;
  Clock::time_point captured;  ///< exposure if the source provides it, else arrival
  bool resets_before{false};   ///< nothing that came before belongs to it: Pipeline::reset()
  std::size_t recorded{0};     ///< index of the frame in the recording that is replayed
};

/// Unused frames, with the reason.
struct Drop {
  std::string reason;
  std::int64_t frames{0};
};

/// Live frames. At most one waits: a newer frame replaces it, and the drop is counted. All functions may be called from
/// any thread; next() from one at a time.
class STEREOGRID_EXPORT LiveSource {
 public:
  LiveSource() = default;
  LiveSource(const LiveSource&) = delete;
  LiveSource& operator=(const LiveSource&) = delete;
  virtual ~LiveSource();

  [[nodiscard]] virtual const Rig& rig() const = 0;
  /// Rigs of all cameras, by StereoFrame::camera; the first is rig().
  [[nodiscard]] virtual std::span<const Rig> rigs() const { return {&rig(), 1}; }
  /// Names of several cameras (PipelineOptions::camera_names); empty: there is one.
  [[nodiscard]] virtual std::vector<std::string> camera_names() const { return {}; }
  /// Newest frame that was not returned yet. Waits up to `patience`; none: timeout, or the source has ended. Throws
  /// InputError for an unusable frame (it is counted); the next one may be usable.
  [[nodiscard]] virtual std::optional<LiveFrame> next(std::chrono::milliseconds patience) = 0;
  /// Nothing will come any more, and next() has thrown what broke the source, if something did.
  [[nodiscard]] virtual bool has_ended() const = 0;
  /// Present fault and its remedy; empty: none.
  [[nodiscard]] virtual std::string fault() const = 0;
  /// Since the source was opened.
  [[nodiscard]] virtual std::vector<Drop> dropped() const = 0;
};

/// A stereo pair of a vehicle with several; `name`: its namespace (io::camera_names).
struct NamedSource {
  std::string name;
  std::unique_ptr<LiveSource> source;
};

/// One source of the stereo pairs of one vehicle, by StereoFrame::camera and `others`. Each frame of the first camera
/// has the nearest frames of the others, within half of the shorter interval, as a recording's have. It waits for those
/// that are due, up to their interval. A camera without a frame for three intervals has stopped: the others continue,
/// with the stamps of the next camera, and fault() names it. One camera: its own source.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<LiveSource> join_cameras(std::vector<NamedSource> cameras);

struct ReplayOptions {
  bool loops{false};     ///< begins again after the last frame
  double speed{1};       ///< 2: twice as fast; more than 0. Stamps stay those of the recording, moved to now
  std::size_t first{0};  ///< frames [first, last) of the source
  std::size_t last{0};   ///< 0: all
};

/// A recording as if it happened now: each frame comes when its stamp says. Where loading takes longer than that,
/// frames come late and none is lost for it. The source has to live longer.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<LiveSource> replay(const FrameSource& source,
                                                                   const ReplayOptions& options = {});

}  // namespace stereogrid::capture
