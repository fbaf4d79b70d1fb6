// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "gstreamer/pipeline.hpp"
#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::capture {
namespace {

using namespace std::chrono_literals;

constexpr auto stalled_after{5s};
constexpr auto first_pause{500ms};
constexpr auto longest_pause{4s};

class GstCamera final : public LiveSource {
 public:
  GstCamera(std::string description, const io::Calibration& calibration, const CameraOptions& options)
      : description_{std::move(description)}, loops_{options.loops}, pair_{calibration, options.pairing} {
    static_cast<void>(GstStream{description_, pair_});  // throws what no new attempt would mend
    thread_ = std::jthread{[this](const std::stop_token& stop) { keep_running(stop); }};
  }

  [[nodiscard]] const Rig& rig() const override { return pair_.rig(); }
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds patience) override {
    return pair_.next(patience);
  }
  [[nodiscard]] bool has_ended() const override { return pair_.has_ended(); }
  [[nodiscard]] std::string fault() const override { return pair_.fault(); }
  [[nodiscard]] std::vector<Drop> dropped() const override { return pair_.dropped(); }

 private:
  void keep_running(const std::stop_token& stop);
  /// Until it ends; true: as a file ends, false: as a camera is lost.
  [[nodiscard]] bool run(const std::stop_token& stop);
  void lose(const std::string& why) { pair_.set_fault(fmt::format("The camera is lost: {} It is tried again.", why)); }
  void pause(const std::stop_token& stop, Clock::duration time);

  const std::string description_;
  const bool loops_;
  CameraPair pair_;
  bool has_worked_{false};  // since it was last lost
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::jthread thread_;
};

void GstCamera::pause(const std::stop_token& stop, Clock::duration time) {
  std::unique_lock lock{mutex_};
  stopped_.wait_for(lock, stop, time, [] { return false; });
}

bool GstCamera::run(const std::stop_token& stop) {
  GstStream stream{description_, pair_};
  Clock::time_point last{Clock::now()};
  const Clock::time_point started{last};
  std::int64_t images{0};
  has_worked_ = false;
  stream.start();
  while (!stop.stop_requested()) {
    const PipelineEvent event{stream.wait(100ms)};
    if (event == PipelineEvent::ended && !stream.is_live() && (stream.images() > 0 || !loops_)) return true;
    const Clock::time_point now{Clock::now()};
    if (std::exchange(images, stream.images()) != stream.images()) last = now;
    const bool has_stalled{now - last > stalled_after};
    if (event == PipelineEvent::ended) lose("its stream has ended.");
    if (event == PipelineEvent::failed) lose(stream.why());
    if (event == PipelineEvent::none && has_stalled) lose("no image has come for 5 s.");
    if (event != PipelineEvent::none || has_stalled) return false;
    has_worked_ = has_worked_ || pair_.silent_for() < now - started;
  }
  return true;
}

void GstCamera::keep_running(const std::stop_token& stop) {
  Clock::duration patience{first_pause};
  try {
    while (!stop.stop_requested()) {
      if (run(stop)) {
        if (!loops_) break;
        pair_.request_reset();
        continue;
      }
      patience = has_worked_ ? Clock::duration{first_pause} : std::min<Clock::duration>(2 * patience, longest_pause);
      pause(stop, patience);
    }
  } catch (const std::exception& error) {  // failure to rebuild a pipeline that worked before
    pair_.set_fault(error.what());
  }
  pair_.end();
}

}  // namespace

std::unique_ptr<LiveSource> open_gstreamer(const std::string& description, const io::Calibration& calibration,
                                           const CameraOptions& options) {
  return std::make_unique<GstCamera>(description, calibration, options);
}

}  // namespace stereogrid::capture
