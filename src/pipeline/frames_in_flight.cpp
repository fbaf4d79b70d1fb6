// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frames_in_flight.hpp"

#include <utility>

#include "held_bytes.hpp"
#include "pipeline/results.hpp"

namespace stereogrid {

FramesInFlight::FramesInFlight(std::function<void(const StereoFrame&, FrameResult&)> work)
    : work_{std::move(work)}, thread_{[this] { keep_working(); }} {}

FramesInFlight::~FramesInFlight() {
  {
    const std::scoped_lock lock{mutex_};
    is_over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FramesInFlight::submit(StereoFrame frame) {
  {
    const std::scoped_lock lock{mutex_};
    slot_of(submitted_).frame = std::move(frame);
    ++submitted_;
  }
  changed_.notify_all();
}

const FrameResult& FramesInFlight::collect() {
  std::unique_lock lock{mutex_};
  changed_.wait(lock, [this] { return worked_on_ > collected_; });
  Slot& slot{slot_of(collected_)};
  ++collected_;
  if (slot.error) std::rethrow_exception(std::exchange(slot.error, nullptr));
  return slot.result;
}

std::optional<FramesInFlight::Waiting> FramesInFlight::next() {
  const std::scoped_lock lock{mutex_};
  if (submitted_ <= worked_on_ + 1) return std::nullopt;
  Slot& slot{slot_of(worked_on_ + 1)};
  return Waiting{slot.frame, slot.result};
}

void FramesInFlight::keep_working() {
  std::unique_lock lock{mutex_};
  for (;;) {
    changed_.wait(lock, [this] { return is_over_ || submitted_ > worked_on_; });
    if (is_over_) return;
    Slot& slot{slot_of(worked_on_)};
    lock.unlock();
    try {
      work_(slot.frame, slot.result);
    } catch (...) {
      slot.error = std::current_exception();
    }
    lock.lock();
    ++worked_on_;
    changed_.notify_all();
  }
}

std::size_t FramesInFlight::held_bytes() const {
  std::size_t bytes{sizeof *this};
  for (const Slot& slot : slots_) {
    bytes += held_bytes_of(slot.frame.left, slot.frame.right, slot.frame.disparity, slot.result);
  }
  return bytes;
}

}  // namespace stereogrid
