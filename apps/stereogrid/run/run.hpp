// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cli/config_options.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "diagnostics/frame_tally.hpp"
#include "frame_stages.hpp"
#include "input.hpp"
#include "run/result_writer.hpp"
#include "stereogrid/capture/frame_loop.hpp"
#include "stereogrid/io/frame_queue.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

struct RunOptions {
  InputOptions input;
  std::string folder;
  ConfigOptions config;
  std::string fuse{"none"};
  std::vector<double> predict_s;
  std::string frames;
  int warm_up{0};
  DeviceOptions device;
  bool compact{false};
  std::size_t every{1};
  std::vector<std::string> layers;  ///< none: all
  bool save_stages{false};
  std::string pictures;  ///< "png", "svg"; "": none
  std::string video;
  MessageOptions messages;
  bool view{false};
  PageOptions page;
  bool resume{false};
  int checkpoint_every{100};
  int input_wait_s{300};
};

/// --layers as the files call them, in their order, each once. Throws ConfigError: there is no such layer.
[[nodiscard]] std::vector<std::string> layers_of(const RunOptions& options);

/// `stereogrid run`. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int run(const RunOptions& options);

/// Wall-clock seconds of a run.
struct RunSeconds {
  double total{0};
  double reading{0};  ///< in which the pipeline waited for the input
  double writing{0};  ///< in which the pipeline waited for the files of results
};

/// A word of a command line, in quotes if the shell needs them.
[[nodiscard]] std::string shell_word(const std::string& word);

/// Numbers of frames and times of a run, and the commands for its results. `frames`: number of those that this
/// run has processed.
[[nodiscard]] std::string summary_of(const RunOptions& options, const Input& input, const io::RunRecord& record,
                                     int frames, const RunSeconds& seconds, bool is_complete);

class Progress;

/// Takes the frames of the input through the pipeline and to the files.
class RunLoop final : private capture::FrameHandler {
 public:
  /// `first_frame`: from there on frames go through the pipeline; those that are finished already are not written.
  RunLoop(Pipeline& pipeline, PoseStage& poses, const FusionStage& fusion, io::RunRecord& record, ResultWriter& writer,
          std::size_t first_frame, const io::Checkpoints& checkpoints, int input_wait_s);

  void run(const FrameSource& source);

  /// Saves the state of pipeline and odometry after the last processed frame. False: no frame was processed, or the
  /// odometry, which runs ahead, has not kept it.
  bool save_state() const;

  [[nodiscard]] bool is_complete() const { return next_ == record_.range().end && unavailable_.empty(); }
  /// Why the frame after the last one could not be read, although it was there; "": it could.
  [[nodiscard]] const std::string& unavailable() const { return unavailable_; }
  /// Number of frames processed and written by run().
  [[nodiscard]] int frames_done() const { return frames_done_; }
  [[nodiscard]] const RunSeconds& seconds() const { return seconds_; }
  [[nodiscard]] const PlaceCheck& places() const { return places_; }

 private:
  [[nodiscard]] std::optional<capture::PreparedFrame> next() override;
  [[nodiscard]] bool has_ended() const override { return has_ended_; }
  void deliver(capture::PreparedFrame& prepared, FrameResult& result) override;
  void refuse(const std::string& reason) override { skip(reason); }
  /// False: frames or the lidar's sweep are unavailable, or there are no more frames.
  bool load();
  [[noreturn]] void give_up_waiting();
  std::optional<io::Checkpoint> checkpoint_after(std::size_t index);
  void skip(const std::string& reason);
  void save_skipped();
  void log_warnings(const std::string& name, const std::vector<Warning>& warnings);

  Pipeline& pipeline_;
  PoseStage& poses_;
  const FusionStage& fusion_;
  io::RunRecord& record_;
  ResultWriter& writer_;
  std::size_t first_frame_;
  io::Checkpoints checkpoints_;
  int input_wait_s_;
  std::size_t first_to_write_;
  std::size_t next_{first_to_write_};
  io::FrameQueue* queue_{nullptr};  ///< while run() runs
  Progress* progress_{nullptr};
  io::QueuedFrame queued_;                     ///< frame in work
  std::optional<std::string> fusion_warning_;  ///< about the other source of the last frame
  bool has_ended_{false};
  std::string unavailable_;
  std::optional<std::size_t> last_processed_;
  int frames_done_{0};
  std::size_t skipped_saved_{0};
  RunSeconds seconds_;
  PlaceCheck places_{5};
  std::set<std::string> reported_;
};

}  // namespace stereogrid::app
