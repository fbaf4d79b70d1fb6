// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "shared_memory/layout.hpp"
#include "stereogrid/capture/shared_memory.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::capture {
namespace {

using namespace std::chrono_literals;

/// Shared memory as a file: who reads it so is not hurt where its writer makes it shorter.
class SharedFile {
 public:
  explicit SharedFile(const std::string& name) : descriptor_{shm_open(name.c_str(), O_RDONLY | O_CLOEXEC, 0)} {}
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;
  ~SharedFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  /// Another one has its name now, or none.
  [[nodiscard]] bool is_gone() const {
    struct stat status {};
    return fstat(descriptor_, &status) != 0 || status.st_nlink == 0;
  }
  [[nodiscard]] bool read(void* to, std::size_t bytes, std::size_t offset) const {
    const bool all{pread(descriptor_, to, bytes, static_cast<off_t>(offset)) == static_cast<ssize_t>(bytes)};
    std::atomic_thread_fence(std::memory_order_acquire);
    return all;
  }
  [[nodiscard]] bool read(Image<std::uint8_t>& image, std::size_t offset) const {
    return read(image.data(), image.size(), offset);
  }

 private:
  int descriptor_;
};

class SharedCamera final : public LiveSource {
 public:
  SharedCamera(const std::string& name, const io::Calibration& calibration, const PairingOptions& options)
      : name_{shared_name(name)}, pair_{calibration, options} {
    thread_ = std::jthread{[this](const std::stop_token& stop) { keep_reading(stop); }};
  }

  [[nodiscard]] const Rig& rig() const override { return pair_.rig(); }
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds patience) override {
    return pair_.next(patience);
  }
  [[nodiscard]] bool has_ended() const override { return pair_.has_ended(); }
  [[nodiscard]] std::string fault() const override { return pair_.fault(); }
  [[nodiscard]] std::vector<Drop> dropped() const override;

 private:
  void keep_reading(const std::stop_token& stop);
  /// Until the writer is gone.
  void follow(const SharedFile& file, const std::stop_token& stop);
  [[nodiscard]] bool is_usable(const SharedHeader& header);
  /// False: it was overwritten meanwhile.
  [[nodiscard]] bool take(const SharedFile& file, const SharedHeader& header);
  void pause(const std::stop_token& stop, Clock::duration time);

  const std::string name_;
  CameraPair pair_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
  std::atomic<std::int64_t> overwritten_{0};
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::jthread thread_;
};

std::vector<Drop> SharedCamera::dropped() const {
  std::vector<Drop> drops{pair_.dropped()};
  if (overwritten_ > 0) drops.push_back({"overwritten in shared memory before it was read", overwritten_});
  return drops;
}

void SharedCamera::pause(const std::stop_token& stop, Clock::duration time) {
  std::unique_lock lock{mutex_};
  stopped_.wait_for(lock, stop, time, [] { return false; });
}

bool SharedCamera::is_usable(const SharedHeader& header) {
  const Rig& rig{pair_.rig()};
  if (header.magic != SharedHeader{}.magic || header.slots < 2 || header.slots > shared_slots_max) {
    pair_.set_fault(fmt::format("Shared memory {} does not begin as docs/live.md says, or not yet.", name_));
    return false;
  }
  if (header.width_px != static_cast<std::uint32_t>(rig.width_px) ||
      header.height_px != static_cast<std::uint32_t>(rig.height_px)) {
    pair_.set_fault(fmt::format("Shared memory {} has images of {}×{} px, but the calibration is for {}×{}.", name_,
                                header.width_px, header.height_px, rig.width_px, rig.height_px));
    return false;
  }
  return true;
}

bool SharedCamera::take(const SharedFile& file, const SharedHeader& header) {
  const std::size_t image_bytes{left_.size()};
  const std::size_t at{sizeof(SharedHeader) +
                       (header.written - 1) % header.slots * slot_bytes(header.width_px, header.height_px)};
  SharedSlot before;
  SharedSlot after;
  const bool is_whole{file.read(&before, sizeof before, at) && file.read(left_, at + sizeof before) &&
                      file.read(right_, at + sizeof before + image_bytes) && file.read(&after, sizeof after, at)};
  if (!is_whole || before.finished != header.written || after.begun != header.written) return false;
  const Clock::time_point now{Clock::now()};
  const Clock::time_point told{std::chrono::nanoseconds{before.captured_ns}};
  const auto view = [](const Image<std::uint8_t>& image) {
    return PixelView{image.data(), image.width(), image.height()};
  };
  pair_.add(view(left_), view(right_), before.captured_ns > 0 && told < now ? told : now);
  return true;
}

void SharedCamera::follow(const SharedFile& file, const std::stop_token& stop) {
  SharedHeader header;
  std::uint64_t last{0};
  bool is_first{true};
  for (int polls{0}; !stop.stop_requested(); ++polls) {
    if (polls % 256 == 255 && file.is_gone()) {
      pair_.set_fault(fmt::format("The writer of shared memory {} has gone. It is waited for.", name_));
      return;
    }
    if (!file.read(&header, sizeof header, 0) || !is_usable(header)) {
      pause(stop, 200ms);
      if (file.is_gone()) return;
      continue;
    }
    if (header.written != last && header.written != 0) {
      const bool is_taken{take(file, header)};
      if (!is_first && header.written > last) {
        overwritten_ += static_cast<std::int64_t>(header.written - last) - (is_taken ? 1 : 0);
      }
      is_first = false;
      last = header.written;
    }
    pause(stop, 1ms);
  }
}

void SharedCamera::keep_reading(const std::stop_token& stop) {
  try {
    left_ = Image<std::uint8_t>{pair_.rig().width_px, pair_.rig().height_px};
    right_ = left_;
    while (!stop.stop_requested()) {
      if (const SharedFile file{name_}; file.is_open()) {
        follow(file, stop);
      } else {
        pair_.set_fault(fmt::format("There is no shared memory {}. Its writer is waited for.", name_));
      }
      pause(stop, 200ms);
    }
  } catch (const std::exception& error) {
    pair_.set_fault(error.what());
  }
  pair_.end();
}

}  // namespace

std::unique_ptr<LiveSource> open_shared_memory(const std::string& name, const io::Calibration& calibration,
                                               const PairingOptions& options) {
  return std::make_unique<SharedCamera>(name, calibration, options);
}

}  // namespace stereogrid::capture
