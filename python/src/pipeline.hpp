// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "device_options.hpp"
#include "recording.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid::python {

/// Results whose memory is used again. A result that Python releases returns its memory here, so that a loop which
/// keeps none allocates as little as the C++ loop does.
class ResultPool {
 public:
  [[nodiscard]] std::unique_ptr<FrameResult> take();
  void give_back(std::unique_ptr<FrameResult> result) noexcept;

 private:
  static constexpr std::size_t capacity_{4};
  std::mutex mutex_;
  std::vector<std::unique_ptr<FrameResult>> free_;
};

/// Result of a frame that Python owns. Views point into it and keep it alive; no later frame changes it.
struct Result {
  explicit Result(std::shared_ptr<ResultPool> results) : pool{std::move(results)}, memory{pool->take()} {}
  Result(const Result&) = delete;
  Result& operator=(const Result&) = delete;
  ~Result() { pool->give_back(std::move(memory)); }

  std::shared_ptr<ResultPool> pool;
  std::unique_ptr<FrameResult> memory;
  FrameResult& data{*memory};
  std::string name;
  std::int64_t index{0};
  std::int64_t stamp_ns{0};
};

/// A Result in Python.
using ResultObject = nanobind::typed<nanobind::object, Result>;

/// Fields of obstacles as one-dimensional arrays, and kinds as a list; outlines and covariances are left out.
[[nodiscard]] nanobind::dict table_of(const std::vector<Obstacle>& obstacles);

/// Grid layers in the memory of a GPU.
struct DeviceLayers {
  const float* data;
  std::vector<std::size_t> shape;
  int device;  ///< as numbered by CUDA
};

/// DeviceGrids in Python.
struct PyDeviceGrids {
  DeviceLayers observed, vehicle, world;
};

/// Optional arguments of process() with arrays.
struct ArrayFrame {
  ImageArguments images;
  std::optional<std::int64_t> stamp_ns;
  std::optional<Pose2> pose;
  std::vector<ObservedGrid> other_grids;
};

/// A pipeline that rejects calls from two threads at once: their order would decide about the results.
class PyPipeline {
 public:
  PyPipeline(const Config& config, const std::vector<MountedRig>& rigs, const app::DeviceOptions& device,
             PipelineOptions options)
      : pipeline_{config, without_masks(rigs), with(std::move(options), rigs, device)} {
    PipelineOptions chosen;
    app::set_device(chosen, device);
    gpu_ = chosen.device;
  }

  [[nodiscard]] ResultObject process(const Frame& frame);
  /// Frames of several cameras.
  [[nodiscard]] ResultObject process(const std::vector<const Frame*>& frames);
  [[nodiscard]] ResultObject process(ArrayFrame arrays);
  [[nodiscard]] PyDeviceGrids device_grids();

  template <class Do>
  auto exclusively(const Do& act) {
    const Busy busy{*this};
    return act(pipeline_);
  }
  /// Access to constant members.
  [[nodiscard]] const Pipeline& pipeline() const { return pipeline_; }

 private:
  class Busy {
   public:
    explicit Busy(PyPipeline& pipeline);
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;
    ~Busy() { flag_.clear(); }

   private:
    std::atomic_flag& flag_;
  };

  static PipelineOptions with(PipelineOptions options, const std::vector<MountedRig>& rigs,
                              const app::DeviceOptions& device);
  /// Created before the frame is processed, as the processor's caches hold nothing of Python after it.
  [[nodiscard]] ResultObject new_result() const { return nb::cast(std::make_unique<Result>(results_)); }
  /// Issues a RuntimeWarning for each kind of warning of the result that is new. Throws python_error where a filter
  /// makes it an exception.
  void warn_once(const FrameResult& result);
  /// Without the GIL.
  template <class Images>
  void run(const Frame& frame, const Images& images, Result& result);

  Pipeline pipeline_;
  int gpu_;  ///< index of a GPU
  std::shared_ptr<ResultPool> results_{std::make_shared<ResultPool>()};
  Frame frame_;  // frame built from arrays; its memory is reused
  std::int64_t next_stamp_ns_{0};
  std::int64_t next_index_{0};
  std::set<std::string> warned_;
  std::atomic_flag busy_;
};

}  // namespace stereogrid::python
