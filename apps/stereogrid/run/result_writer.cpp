// SPDX-License-Identifier: Apache-2.0
#include "run/result_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "locks/folder_lock.hpp"
#include "pictures/drawing.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/run_folder/description.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"

namespace stereogrid::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t capacity{4};

/// frames.jsonl, open for appending.
class LineFile {
 public:
  explicit LineFile(fs::path path)
      : path_{std::move(path)}, file_{open_file(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND)} {
    check(file_.get() >= 0);
  }

  void append(const std::string& line) { check(write_all(file_.get(), line + '\n')); }
  void close() { check(file_.close()); }

 private:
  void check(bool done) const {
    if (done) return;
    throw DeviceError{fmt::format("{}: cannot be written ({}). Free some space, then continue with --resume.",
                                  path_.string(), std::generic_category().message(errno))};
  }

  fs::path path_;
  Descriptor file_;
};

struct Job {
  capture::PreparedFrame prepared;
  FrameResult result;
  std::optional<io::Checkpoint> checkpoint;
};

}  // namespace

struct ResultWriter::State {
  explicit State(WriterOptions writer_options) : options{std::move(writer_options)} {
    io::create_folder(options.folder / "grids");
    if (options.predictions) io::create_folder(options.folder / "predictions");
    if (options.stages) io::create_folder(options.folder / "stages");
    if (!options.pictures.empty()) io::create_folder(options.folder / "pictures");
    lines.emplace(options.folder / "frames.jsonl");
    if (!options.video.empty()) video.emplace(options.video, options.video_rate_hz);
    if (!has_receivers(options.messages) && options.page == nullptr) return;
    messages.emplace(options.messages, options.page != nullptr ? &options.page->server() : nullptr, options.rig);
  }

  void write_frame(const Job& job) {
    const std::string file{job.prepared.frame.name + ".npz"};
    const auto write{options.compact ? io::write_compact_grids : io::write_grids};
    write(options.folder / "grids" / file, job.result, options.layers);
    if (options.predictions) io::write_predictions(options.folder / "predictions" / file, job.result);
    if (options.stages) io::write_stages(options.folder / "stages" / file, job.result.stages);
    const fs::path image{options.folder / "pictures" / (job.prepared.frame.name + '.' + options.pictures)};
    if (options.pictures == "svg") io::write_file(image, draw_svg(job.prepared.frame, job.result));
    if (options.pictures == "png" || video) {
      const io::RgbImage picture{draw_picture(job.prepared.frame, job.result)};
      if (options.pictures == "png") io::write_png(image, picture);
      if (video) video->add(picture);
    }
    if (messages) send(job);
    lines->append(io::frame_line(job.prepared.frame, job.result, job.result.rig, options.compact));
    if (job.checkpoint) io::write_checkpoint(options.folder, *job.checkpoint);
  }

  void send(const Job& job) {
    ++sent;
    const std::size_t due{
        io::multiples_between(options.first_frame, static_cast<std::size_t>(job.prepared.frame.index), options.every)};
    const std::array<messages::Dropped, 1> dropped{{{"cannot be used", static_cast<std::int64_t>(due) - sent}}};
    const messages::FrameFacts facts{.frames = sent, .dropped = dropped, .covariances = job.prepared.covariances};
    messages->send(job.prepared.frame, job.result, facts);
    if (options.page != nullptr) options.page->note(job.result, facts);
  }

  void work() {
    std::unique_lock lock{mutex};
    for (;;) {
      changed.wait(lock, [this] { return ended || !jobs.empty(); });
      if (jobs.empty()) return;
      Job job{std::move(jobs.front())};
      jobs.pop_front();
      changed.notify_all();
      lock.unlock();
      std::exception_ptr caught;
      try {
        write_frame(job);
      } catch (...) {
        caught = std::current_exception();
      }
      lock.lock();
      written = std::move(job.result);
      if (!caught) continue;
      failure = caught;
      changed.notify_all();
      return;
    }
  }

  WriterOptions options;
  std::optional<LineFile> lines;
  std::optional<Video> video;
  std::optional<MessageOutput> messages;
  std::int64_t sent{0};
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Job> jobs;
  FrameResult written;  ///< the last one, until its memory is used again
  std::exception_ptr failure;
  bool ended{false};
  std::thread thread;
};

ResultWriter::ResultWriter(WriterOptions options) : state_{std::make_unique<State>(std::move(options))} {
  state_->thread = std::thread{[this] { state_->work(); }};
}

ResultWriter::~ResultWriter() {
  {
    const std::lock_guard lock{state_->mutex};
    state_->ended = true;
    state_->jobs.clear();
  }
  state_->changed.notify_all();
  if (state_->thread.joinable()) state_->thread.join();
}

FrameResult ResultWriter::write(capture::PreparedFrame prepared, FrameResult result,
                                std::optional<io::Checkpoint> checkpoint) {
  std::unique_lock lock{state_->mutex};
  state_->changed.wait(lock, [this] { return state_->failure || state_->jobs.size() < capacity; });
  if (state_->failure) std::rethrow_exception(state_->failure);
  state_->jobs.push_back({std::move(prepared), std::move(result), std::move(checkpoint)});
  state_->changed.notify_all();
  return std::exchange(state_->written, {});
}

void ResultWriter::finish() {
  {
    const std::lock_guard lock{state_->mutex};
    state_->ended = true;
  }
  state_->changed.notify_all();
  state_->thread.join();
  if (state_->failure) std::rethrow_exception(state_->failure);
  state_->lines->close();
  if (state_->video) state_->video->finish();
  if (state_->messages) state_->messages->finish();
}

}  // namespace stereogrid::app
