// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::capture {

/// Turns this process's clock into Unix time; by the same offset always, so that a clock that is set does not reorder
/// frames.
class UnixTime {
 public:
  [[nodiscard]] std::int64_t ns(Clock::time_point instant) const { return offset_ns_ + nanoseconds(instant); }

 private:
  template <class T>
  static std::int64_t nanoseconds(T instant) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()).count();
  }

  std::int64_t offset_ns_{nanoseconds(std::chrono::system_clock::now()) - nanoseconds(Clock::now())};
};

struct CapturedPair {
  io::ImagePair images;
  Clock::time_point captured;  ///< capture time of the left image
  int stream{0};
};

/// An image of one camera, or depth of the left image instead of the right one.
struct Shot {
  io::ScaledImage image;
  Image<float> depth_m{};
};

/// Finds the images of two cameras that belong together by their instants. Of each camera images come in the order in
/// which they were taken.
class Pairing {
 public:
  Pairing(const PairingOptions& options, Clock::time_point now);

  /// The pair that the image completes.
  std::optional<CapturedPair> add(Side side, Shot shot, Clock::time_point captured, Clock::time_point now);
  /// A pair has come by itself.
  void note_pair(Clock::time_point now);

  void set_tolerance(std::chrono::nanoseconds tolerance) { options_.tolerance = tolerance; }
  /// Why there have been no pairs for PairingOptions::silence; empty: there were.
  [[nodiscard]] std::string fault(Clock::time_point now) const;
  /// Images that remained without a partner.
  [[nodiscard]] std::int64_t alone(Side side) const { return of(side).alone; }
  [[nodiscard]] Clock::time_point last_image() const;

 private:
  struct Waiting {
    Shot shot;
    Clock::time_point captured;
  };
  struct Camera {
    std::deque<Waiting> waiting;
    std::int64_t alone{0};
    Clock::time_point last_image;
  };

  [[nodiscard]] Camera& of(Side side) { return cameras_[side == Side::left ? 0 : 1]; }
  [[nodiscard]] const Camera& of(Side side) const { return cameras_[side == Side::left ? 0 : 1]; }
  /// The place of the image that was taken nearest to the instant, where there is any.
  [[nodiscard]] static std::optional<std::size_t> nearest(const Camera& camera, Clock::time_point captured);
  static void drop(Camera& camera, std::size_t images);

  PairingOptions options_;
  std::array<Camera, 2> cameras_;
  Clock::time_point last_pair_;
  std::optional<Clock::duration> apart_;  // the last image and the nearest one of the other camera
};

}  // namespace stereogrid::capture
