// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "stereogrid/capture/frame_loop.hpp"
#include "stereogrid/io/ffmpeg.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/run_folder/checkpoint.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Arguments of ffmpeg for a file: an animated image for the endings .gif and .webp, no wider than 960 px, else H.264.
[[nodiscard]] std::vector<std::string> encoder_of(const std::filesystem::path& file);

/// A film, encoded by the program ffmpeg. It gets its name when it is whole.
class Video {
 public:
  /// Throws DeviceError: ffmpeg is missing, the folder cannot be written.
  Video(const std::filesystem::path& file, double rate_hz);
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;
  /// Without finish(): nothing is left.
  ~Video();

  /// Adds an image. All have the size of the first; an odd last row or column is left out. Throws DeviceError.
  void add(const io::RgbImage& picture);
  /// Throws DeviceError where ffmpeg has failed.
  void finish();

 private:
  std::filesystem::path file_;
  std::filesystem::path unfinished_;
  double rate_hz_;
  std::optional<io::Ffmpeg> ffmpeg_;
};

struct WriterOptions {
  std::filesystem::path folder;
  bool predictions{false};
  bool compact{false};
  std::size_t every{1};  ///< multiples of it are written
  std::vector<std::string> layers{};
  bool stages{false};
  std::string pictures;         ///< "png", "svg"; "": none
  std::filesystem::path video;  ///< empty: none
  double video_rate_hz{10};
  MessageOptions messages{};
  Page* page{nullptr};         ///< receives the results, too, and outlives this object; none: no viewers
  Rig rig{};                   ///< rig of the first frame
  std::size_t first_frame{0};  ///< its place in the input
};

/// Writes the files of each frame on a thread of its own, in the order of the frames, while the pipeline processes the
/// next ones. A frame's line in frames.jsonl comes last: frames with a line are complete.
class ResultWriter {
 public:
  /// Makes the folders. Throws DeviceError.
  explicit ResultWriter(WriterOptions options);
  ResultWriter(const ResultWriter&) = delete;
  ResultWriter& operator=(const ResultWriter&) = delete;
  /// Frames that wait are lost without finish().
  ~ResultWriter();

  /// Waits while too many frames wait. Throws what writing an earlier frame has thrown: DeviceError.
  /// `checkpoint`: written once the frame is. Returns the result of a frame that is written, whose memory can be used
  /// again, or an empty one.
  FrameResult write(capture::PreparedFrame prepared, FrameResult result, std::optional<io::Checkpoint> checkpoint = {});
  /// Waits for the last frame; throws as write().
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::app
