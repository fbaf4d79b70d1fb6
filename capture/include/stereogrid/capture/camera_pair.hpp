// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid::capture {

enum class Side { left, right };

struct PairingOptions {
  std::chrono::nanoseconds tolerance{std::chrono::milliseconds{10}};  ///< between the two exposures of a pair
  std::chrono::nanoseconds silence{std::chrono::seconds{2}};          ///< so long without a pair is a fault
  bool has_depth{false};                                              ///< add_depth() replaces the right images
};

/// Source of two cameras whose images the caller adds: pairs them by their stamps and rectifies them. The other camera
/// sources use it, and programs with a camera library of their own. Functions that take images may be called from any
/// thread. Of grey16, `bits` 0 of a view means: found from the images (io::share_scale with the most bits so far), the
/// same for both of a pair.
class STEREOGRID_EXPORT CameraPair final : public LiveSource {
 public:
  /// Images as the calibration has them: of its size, raw where it says so. Throws InputError: it has no size, or
  /// cannot be rectified.
  explicit CameraPair(const io::Calibration& calibration, const PairingOptions& options = {});
  ~CameraPair() override;

  /// An image of one camera; it waits for that of the other. Throws InputError where it is not of the calibration's
  /// size, or as assign() of pixel_view.hpp.
  void add(Side side, const PixelView& image, Clock::time_point captured);
  void add(Side side, io::ScaledImage image, Clock::time_point captured);
  /// Depth per pixel of the left image instead of a right image: metres along the camera's axis, 0 = none. The frame
  /// has its disparity. Throws InputError where it is not of the calibration's size.
  void add_depth(Image<float> depth_m, Clock::time_point captured);
  /// Both at once, as a camera gives them that takes them together.
  void add(const PixelView& left, const PixelView& right, Clock::time_point captured);
  /// The same in one image, the left camera's in its left half.
  void add_side_by_side(const PixelView& both, Clock::time_point captured);
  /// Counts an unusable image; the next one may be usable.
  void add_unusable();

  /// Sets PairingOptions::tolerance for the images that come from now on.
  void set_tolerance(std::chrono::nanoseconds tolerance);
  /// The camera is lost, or whatever else stands in the way, and what would mend it; until the next pair comes.
  void set_fault(std::string sentence);
  /// Frames that come now are another stream's: LiveFrame::resets_before.
  void request_reset();
  void end();

  [[nodiscard]] const Rig& rig() const override;
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds patience) override;
  [[nodiscard]] bool has_ended() const override;
  [[nodiscard]] std::string fault() const override;
  [[nodiscard]] std::vector<Drop> dropped() const override;
  /// Since the last image of either camera came, or since the pair was made.
  [[nodiscard]] Clock::duration silent_for() const;

 private:
  struct STEREOGRID_HIDDEN State;
  std::unique_ptr<State> state_;
};

struct CameraOptions {
  PairingOptions pairing{};
  bool loops{false};  ///< a stream that ends, such as a file's, begins again
};

/// A GStreamer pipeline in the words of gst-launch-1.0. With two elements `appsink name=left` and `appsink name=right`
/// it has two cameras; with one appsink, or none (then one is put behind its end), both images are side by side. The
/// capture time of a buffer is its running time on the pipeline's clock.
///
/// A pipeline that fails, or gives nothing for five seconds, is made anew, over and over, until it works again; fault()
/// says why it does not. Throws ConfigError: not a pipeline, or one without an end; InputError as CameraPair;
/// DeviceError: built with STEREOGRID_GSTREAMER=OFF.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<LiveSource> open_gstreamer(const std::string& description,
                                                                           const io::Calibration& calibration,
                                                                           const CameraOptions& options = {});

/// The pipeline for two devices of Video4Linux, or one (`right` empty) that gives both images side by side, of the
/// calibration's size each.
[[nodiscard]] STEREOGRID_EXPORT std::string v4l2_pipeline(const std::string& left, const std::string& right,
                                                          const Rig& size);

}  // namespace stereogrid::capture
