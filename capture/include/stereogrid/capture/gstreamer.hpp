// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::capture {

struct CameraOptions {
  PairingOptions pairing{};
  bool loops{false};  ///< a stream that ends, such as a file's, begins again
};

/// A GStreamer pipeline in the words of gst-launch-1.0. With two elements `appsink name=left` and `appsink name=right`
/// it has two cameras; with one appsink, or none (then one is put behind its end), both images are side by side. The
/// capture time of a buffer is its running time on the pipeline's clock.
///
/// A pipeline that fails, or gives nothing for five seconds, is made anew, over and over, until it works again; fault()
/// says why it does not. Throws ConfigError: not a pipeline, or one without an end; InputError as CameraPair.
[[nodiscard]] STEREOGRID_EXPORT std::unique_ptr<LiveSource> open_gstreamer(const std::string& description,
                                                                           const io::Calibration& calibration,
                                                                           const CameraOptions& options = {});

/// The pipeline for two devices of Video4Linux, or one (`right` empty) that gives both images side by side, of the
/// calibration's size each.
[[nodiscard]] STEREOGRID_EXPORT std::string v4l2_pipeline(const std::string& left, const std::string& right,
                                                          const Rig& size);

}  // namespace stereogrid::capture
