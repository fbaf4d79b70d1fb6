// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "arrays.hpp"
#include "device_options.hpp"
#include "recording.hpp"
#include "result.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::python {

/// Optional arguments of process() with arrays.
struct ArrayFrame {
  nb::handle left, right, disparity, depth;  // the caller keeps them alive
  std::optional<double> depth_scale;
  std::optional<std::int64_t> stamp_ns;
  std::optional<Pose2> pose;
  std::vector<ObservedGrid> other_grids;
  PixelOptions pixels;
};

/// A pipeline that rejects calls from two threads at once: their order would decide about the results.
class PyPipeline {
 public:
  PyPipeline(const Config& config, const MountedRig& rig, const app::DeviceOptions& device, PipelineOptions options)
      : pipeline_{config, rig.rig, with(std::move(options), rig, device)} {}

  [[nodiscard]] ResultObject process(const Frame& frame);
  [[nodiscard]] ResultObject process(ArrayFrame arrays);

  template <class Do>
  auto exclusively(const Do& act) {
    const Busy busy{*this};
    return act(pipeline_);
  }
  /// Access to constant members.
  [[nodiscard]] const Pipeline& pipeline() const { return pipeline_; }

 private:
  static constexpr std::int64_t assumed_step_ns_{100'000'000};  // as of recordings without stamps

  class Busy {
   public:
    explicit Busy(PyPipeline& pipeline);
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;
    ~Busy() { flag_.clear(); }

   private:
    std::atomic_flag& flag_;
  };

  static PipelineOptions with(PipelineOptions options, const MountedRig& rig, const app::DeviceOptions& device);
  [[nodiscard]] FrameImages images_of(const ArrayFrame& arrays, const Array& left, const std::optional<Array>& right,
                                      const std::optional<Array>& external);
  /// Created before the frame is processed, as the processor's caches hold nothing of Python after it.
  [[nodiscard]] ResultObject new_result() const { return nb::cast(std::make_unique<Result>(results_)); }
  /// Without the GIL.
  void run(const Frame& frame, const FrameImages& images, Result& result);

  Pipeline pipeline_;
  std::shared_ptr<ResultPool> results_{std::make_shared<ResultPool>()};
  Frame frame_;  // frame built from arrays; its memory is reused
  std::int64_t next_stamp_ns_{0};
  std::int64_t next_index_{0};
  std::atomic_flag busy_;
};

}  // namespace stereogrid::python
