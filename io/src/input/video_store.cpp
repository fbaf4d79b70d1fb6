// SPDX-License-Identifier: Apache-2.0
#include "input/recording_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <map>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <utility>

#include "files/formats.hpp"
#include "input/layout/side_names.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/ffmpeg.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

/// Frames of a file by their place. Decodes in order: going back starts again.
class Video {
 public:
  explicit Video(fs::path path) : path_{std::move(path)} {}

  /// Decodes the whole file, because containers do not all count their frames, and finds the size of its frames.
  std::vector<std::int64_t> stamps_ns() {
    std::istringstream lines{list_of_frames()};
    std::vector<std::int64_t> stamps;
    bool do_grow{true};
    for (std::string line; std::getline(lines, line);) {
      std::int64_t stamp_ns{0};
      static_cast<void>(std::sscanf(line.c_str(), "#dimensions 0: %dx%d", &width_, &height_));
      if (std::sscanf(line.c_str(), "0, %*d, %" SCNd64, &stamp_ns) != 1) continue;
      do_grow = do_grow && (stamps.empty() || stamp_ns > stamps.back());
      stamps.push_back(stamp_ns);
    }
    if (stamps.empty()) fail("is a video that cannot be decoded: it is damaged, or of an unknown codec.");
    check_size(name(), static_cast<std::uint64_t>(width_), static_cast<std::uint64_t>(height_));
    for (std::size_t i{stamps.size()}; i-- > 0;) {
      stamps[i] = do_grow ? stamps[i] - stamps[0] : static_cast<std::int64_t>(i) * usual_step_ns;
    }
    return stamps;
  }

  Image<std::uint8_t> load(std::size_t index) {
    const std::lock_guard lock{mutex_};
    if (const auto found{recent_.find(index)}; found != recent_.end()) return found->second;
    if (!decoder_ || index < next_) open(index - std::min(index, most_recent / 2));
    for (; next_ <= index; ++next_) keep(next_, next_frame());
    return recent_.at(index);
  }

  [[nodiscard]] std::string name() const { return printable_path(path_); }

 private:
  /// Several threads load frames that are close to each other, in any order.
  static constexpr std::size_t most_recent{32};
  static constexpr std::int64_t usual_step_ns{100'000'000};

  void keep(std::size_t index, Image<std::uint8_t> image) {
    recent_.insert_or_assign(index, std::move(image));
    if (recent_.size() > most_recent)
      recent_.erase(index < recent_.rbegin()->first ? std::prev(recent_.end()) : recent_.begin());
  }

  /// All frames of the first stream of images; a playlist must not name other files.
  void start(std::vector<std::string> output) {
    std::vector<std::string> arguments{
        "-loglevel", "quiet",  "-protocol_whitelist", "file",   "-i", "file:" + path_.string(), "-map",
        "0:v:0",     "-vsync", "passthrough",         "-copyts"};
    arguments.insert(arguments.end(), output.begin(), output.end());
    arguments.emplace_back("-");
    decoder_.emplace(Ffmpeg::Pipe::output, std::move(arguments));
  }

  /// A line per frame: stream, two stamps, …
  std::string list_of_frames() {
    start({"-c:v", "rawvideo", "-enc_time_base", "1/1000000000", "-f", "framecrc"});
    std::string text;
    std::array<char, 4096> part{};
    while (const std::size_t size{decoder_->read(part.data(), part.size())}) text.append(part.data(), size);
    decoder_.reset();
    return text;
  }

  void open(std::size_t first) {
    start({"-vf", fmt::format("select=gte(n\\,{}),scale=in_color_matrix=bt601", first), "-f", "rawvideo", "-pix_fmt",
           "bgr24"});
    next_ = first;
  }

  Image<std::uint8_t> next_frame() {
    cv::Mat frame(height_, width_, CV_8UC3);
    const std::size_t bytes{frame.total() * frame.elemSize()};
    if (decoder_->read(frame.ptr<char>(), bytes) != bytes) fail(fmt::format("ends before frame {}.", next_));
    Image<std::uint8_t> image{width_, height_};
    cv::cvtColor(frame, cv::Mat{height_, width_, CV_8UC1, image.data()}, cv::COLOR_BGR2GRAY);
    return image;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError{name(), what, "Record it again, or extract its frames: ffmpeg -i FILE left/%06d.png."};
  }

  fs::path path_;
  int width_{0};
  int height_{0};
  std::optional<Ffmpeg> decoder_;
  std::size_t next_{0};  ///< place of the frame that the decoder is at
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
  std::vector<fs::path> videos{entries_of(folder)};
  std::erase_if(videos, [](const fs::path& entry) { return !has_video_extension(entry); });
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
  if (paths.size() == 1 && is_folder(paths[0])) return pair_of(videos_in(paths[0]));
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
    const std::vector<std::int64_t> right_stamps_ns{right->stamps_ns()};
    const std::size_t right_frames{right_stamps_ns.size()};
    if (frames != right_frames) {
      found.warnings.push_back(fmt::format("{} has {} frames, {} {}: those without a partner are left out",
                                           printable_path(videos.left), frames, printable_path(videos.right),
                                           right_frames));
    }
    found.stamps_ns.resize(std::min(frames, right_frames));
    const std::int64_t off_ns{std::abs(found.stamps_ns.back() - right_stamps_ns[found.stamps_ns.size() - 1])};
    if (2 * off_ns * static_cast<std::int64_t>(found.stamps_ns.size() - 1) > found.stamps_ns.back()) {  // half a frame
      found.warnings.push_back(
          fmt::format("the last pair is of times that differ by {:.3f} s: frame i of both videos is a pair, so "
                      "both need the same frame rate, begin and end",
                      1e-9 * static_cast<double>(off_ns)));
    }
    found.kind = "videos of two cameras";
  }
  found.width_px = size.width_px;
  found.height_px = size.height_px;
  found.images = std::make_unique<VideoStore>(std::move(left), std::move(right), layout);
  return found;
}

}  // namespace stereogrid::io
