// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/video_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

#include "input/layout/side_names.hpp"
#include "input/layout/stacked_images.hpp"
#include "input/video_files.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

/// Frames of a file by their place. Decodes in order: going back starts again.
class Video {
 public:
  explicit Video(fs::path path) : path_{std::move(path)} { open(); }

  /// Decodes the whole file: containers do not all count their frames.
  std::vector<std::int64_t> stamps_ns() {
    const double rate_hz{capture_.get(cv::CAP_PROP_FPS)};
    const double step_ns{1e9 / (rate_hz > 0.01 && rate_hz < 1e4 ? rate_hz : 10)};
    std::vector<std::int64_t> stamps;
    bool do_grow{true};
    for (; grab(); ++next_) {
      stamps.push_back(std::llround(capture_.get(cv::CAP_PROP_POS_MSEC) * 1e6));
      do_grow = do_grow && (stamps.size() == 1 || stamps.back() > stamps[stamps.size() - 2]);
    }
    for (std::size_t i{0}; !do_grow && i < stamps.size(); ++i) {
      stamps[i] = std::llround(static_cast<double>(i) * step_ns);
    }
    if (stamps.empty()) fail("holds no frame that can be decoded.");
    open();
    return stamps;
  }

  Image<std::uint8_t> load(std::size_t index) {
    const std::lock_guard lock{mutex_};
    if (const auto found{recent_.find(index)}; found != recent_.end()) return found->second;
    if (index < next_) open();
    while (next_ <= index) {
      if (!grab()) fail(fmt::format("ends before frame {}.", index));
      if (index - next_ < most_recent / 2) keep(next_, retrieved(next_));
      ++next_;
    }
    return recent_.at(index);
  }

  [[nodiscard]] std::string name() const { return printable_path(path_); }

 private:
  /// Several threads load frames that are close to each other, in any order.
  static constexpr std::size_t most_recent{32};

  void keep(std::size_t index, Image<std::uint8_t> image) {
    recent_.insert_or_assign(index, std::move(image));
    if (recent_.size() > most_recent)
      recent_.erase(index < recent_.rbegin()->first ? std::prev(recent_.end()) : recent_.begin());
  }

  Image<std::uint8_t> retrieved(std::size_t index) {
    cv::Mat frame;
    if (!capture_.retrieve(frame) || frame.empty()) fail(fmt::format("has a frame {} that is damaged.", index));
    if (frame.channels() == 3) cv::cvtColor(frame, frame, cv::COLOR_BGR2GRAY);
    if (frame.type() != CV_8UC1) fail("has frames of another kind than 8-bit grey or colour.");
    Image<std::uint8_t> image{frame.cols, frame.rows};
    for (int v{0}; v < frame.rows; ++v) std::copy_n(frame.ptr<std::uint8_t>(v), frame.cols, image.row(v));
    return image;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError{name(), what, "Record it again, or extract its frames: ffmpeg -i FILE left/%06d.png."};
  }

  bool grab() {
    try {
      return capture_.grab();
    } catch (const cv::Exception&) {
      return false;
    }
  }

  void open() {
    next_ = 0;
    try {
      // other backends take a name for a pattern of images
      if (capture_.open(path_.string(), cv::CAP_FFMPEG)) return;
    } catch (const cv::Exception&) {
    }
    fail("is a video that cannot be decoded: it is damaged, or of an unknown codec.");
  }

  fs::path path_;
  cv::VideoCapture capture_;
  std::size_t next_{0};  ///< place of the frame that grab() decodes
  std::map<std::size_t, Image<std::uint8_t>> recent_;
  std::mutex mutex_;
};

class VideoStore final : public ImageStore {
 public:
  VideoStore(std::unique_ptr<Video> left, std::unique_ptr<Video> right, ImageLayout layout)
      : left_{std::move(left)}, right_{std::move(right)}, layout_{layout} {}

  [[nodiscard]] ImagePair load(std::size_t index) const override {
    if (right_) return {left_->load(index), right_->load(index)};
    return split_pair(left_->load(index), 8, layout_, left_->name());
  }

 private:
  std::unique_ptr<Video> left_;
  std::unique_ptr<Video> right_;  ///< none: both images are in the frames of the other
  ImageLayout layout_;
};

std::vector<fs::path> videos_in(const fs::path& folder) {
  std::vector<fs::path> videos;
  std::error_code error;
  for (fs::directory_iterator entry{folder, error}; !error && entry != fs::directory_iterator{};
       entry.increment(error)) {
    if (has_video_extension(entry->path())) videos.push_back(entry->path());
  }
  std::ranges::sort(videos);
  return videos;
}

std::optional<VideoPair> pair_of(const std::vector<fs::path>& videos) {
  if (videos.size() == 1) return VideoPair{videos[0], {}};
  if (videos.size() != 2) return std::nullopt;
  for (const SideWords& words : all_side_words) {
    for (const auto& [left, right] : {std::pair{videos[0], videos[1]}, std::pair{videos[1], videos[0]}}) {
      const auto rest{without_word(left.stem().string(), words.left)};
      if (rest && rest == without_word(right.stem().string(), words.right)) return VideoPair{left, right};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<VideoPair> find_videos(const std::vector<fs::path>& paths) {
  if (paths.empty() || paths.size() > 2) return std::nullopt;
  if (paths.size() == 1 && fs::is_directory(paths[0])) return pair_of(videos_in(paths[0]));
  if (!std::ranges::all_of(paths, is_video)) return std::nullopt;
  return VideoPair{paths[0], paths.size() == 2 ? paths[1] : fs::path{}};
}

ForeignRecording open_videos(const VideoPair& videos, std::optional<ImageLayout> wanted, const fs::path& calibration) {
  if (!videos.right.empty() && wanted) {
    throw InputError{printable_path(videos.left), "is a video of one camera: --layout has no effect on it.",
                     "Leave --layout out."};
  }
  ForeignRecording found;
  found.root = videos.left;
  auto left{std::make_unique<Video>(videos.left)};
  found.stamps_ns = left->stamps_ns();
  const Image<std::uint8_t> first{left->load(0)};
  Size size{first.width(), first.height()};
  ImageLayout layout{ImageLayout::separate};
  std::unique_ptr<Video> right;
  if (videos.right.empty()) {
    layout = find_layout(size, wanted, calibration, videos.left);
    size = size_of_part(size, layout);
    found.kind = "video of both cameras";
    found.notes.push_back(layout == ImageLayout::side_by_side ? "images: left and right one side by side"
                                                              : "images: the left one above the right one");
  } else {
    right = std::make_unique<Video>(videos.right);
    const std::size_t frames{found.stamps_ns.size()};
    const std::size_t right_frames{right->stamps_ns().size()};
    if (frames != right_frames) {
      found.warnings.push_back(fmt::format("{} has {} frames, {} {}: those without a partner are left out",
                                           printable_path(videos.left), frames, printable_path(videos.right),
                                           right_frames));
    }
    found.stamps_ns.resize(std::min(frames, right_frames));
    found.kind = "videos of two cameras";
  }
  found.width_px = size.width_px;
  found.height_px = size.height_px;
  found.images = std::make_unique<VideoStore>(std::move(left), std::move(right), layout);
  return found;
}

}  // namespace stereogrid::io
