// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gst/app/gstappsink.h>
#include <gst/gst.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "stereogrid/capture/camera_pair.hpp"

namespace stereogrid::capture {

struct GstUnref {
  void operator()(void* object) const { gst_object_unref(object); }
};
template <class T>
using GstPointer = std::unique_ptr<T, GstUnref>;

enum class PipelineEvent { none, ended, failed };

/// A GStreamer pipeline whose images go into a pair of cameras, which has to live longer.
class GstStream {
 public:
  /// Does not start it. Throws ConfigError: see open_gstreamer().
  GstStream(const std::string& description, CameraPair& pair);
  GstStream(const GstStream&) = delete;
  GstStream& operator=(const GstStream&) = delete;
  ~GstStream();

  void start();
  /// Waits for the next event, up to `patience`.
  [[nodiscard]] PipelineEvent wait(std::chrono::milliseconds patience);
  /// Reason after `failed`.
  [[nodiscard]] const std::string& why() const { return why_; }
  /// Its images come from a camera or a network, not from a file.
  [[nodiscard]] bool is_live() const { return is_live_; }
  /// Number of images received, including unusable ones.
  [[nodiscard]] std::int64_t images() const { return images_; }

 private:
  enum class Role { left, right, both };
  struct Output {
    GstStream* stream{nullptr};
    Role role{Role::both};
  };

  void connect(GstAppSink* sink, Output& output);
  static GstFlowReturn take_sample(GstAppSink* sink, void* output);
  void take(GstSample* sample, Role role);
  [[nodiscard]] Clock::time_point instant_of(GstSample* sample) const;

  CameraPair& pair_;
  GstPointer<GstElement> pipeline_;
  std::array<Output, 2> outputs_;
  bool is_live_{false};
  std::atomic<std::int64_t> images_{0};
  std::string why_;
};

}  // namespace stereogrid::capture
