// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "stereogrid/capture/gstreamer.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid::capture {

/// Pairs that another process writes into shared memory of that name (docs/live.md has the layout). There need not be
/// any yet; a writer that ends and begins anew is followed. Throws ConfigError: no name; InputError as CameraPair.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<LiveSource> open_shared_memory(const std::string& name,
                                                                               const io::Calibration& calibration,
                                                                               const PairingOptions& options = {});

/// The other end: pairs of grey images for open_shared_memory() in another process.
class STEREOGRID_EXPORT SharedPairs {
 public:
  /// Replaces shared memory of that name ("/stereo"), which goes away with this object. Throws DeviceError;
  /// ConfigError: a name that cannot be, a size that is not positive.
  SharedPairs(const std::string& name, int width_px, int height_px);
  SharedPairs(const SharedPairs&) = delete;
  SharedPairs& operator=(const SharedPairs&) = delete;
  ~SharedPairs();

  /// `captured_ns`: the exposure on CLOCK_MONOTONIC. Never waits. Throws InputError: another size.
  void write(const PixelView& left, const PixelView& right, std::int64_t captured_ns);

 private:
  struct STEREOGRID_HIDDEN State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::capture
