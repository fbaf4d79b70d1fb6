// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/frame_queue.hpp"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>
#include <vector>

#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

struct Slot {
  bool is_loaded{false};
  bool is_ready{false};  ///< prepared, too
  QueuedFrame frame;
  std::exception_ptr failure;  ///< not the frame's fault
};

/// Runs `work`; what goes wrong is kept in the slot.
template <class Work>
void guarded(Slot& slot, Work work) {
  try {
    work(slot.frame);
  } catch (const InputError& error) {
    slot.frame.frame.reset();
    slot.frame.error = error.what();
  } catch (...) {
    slot.failure = std::current_exception();
  }
}

Slot load(const FrameSource& source, std::size_t index) {
  Slot slot;
  slot.is_loaded = true;
  slot.frame.index = index;
  guarded(slot, [&](QueuedFrame& frame) {
    frame.name = source.name(index);
    frame.frame = source.load(index);
  });
  return slot;
}

void apply(const Preparation& prepare, Slot& slot) {
  if (!prepare || !slot.frame.frame || slot.failure) return;
  const auto start{std::chrono::steady_clock::now()};
  guarded(slot, prepare);
  const std::chrono::duration<double, std::milli> taken{std::chrono::steady_clock::now() - start};
  slot.frame.prepared_ms = taken.count();
}

}  // namespace

struct FrameQueue::State {
  State(const FrameSource& frame_source, std::size_t first, std::size_t end, std::size_t capacity, int threads,
        Preparation preparation)
      : source{frame_source},
        last{end},
        most_tasks{std::max(1, threads)},
        prepare{std::move(preparation)},
        slots(std::max<std::size_t>(1, capacity)),
        to_load{first},
        to_prepare{first},
        to_hand_out{first} {}

  [[nodiscard]] Slot& slot_of(std::size_t index) { return slots[index % slots.size()]; }
  [[nodiscard]] bool has_space() const { return !is_stopped && to_load < std::min(last, to_hand_out + slots.size()); }

  /// Loads the next frame. Here and below, the lock is released for the time of the work.
  void load_next(std::unique_lock<std::mutex>& lock) {
    ++in_work;
    const std::size_t index{to_load++};
    lock.unlock();
    Slot slot{load(source, index)};
    lock.lock();
    slot_of(index) = std::move(slot);
    prepare_loaded(lock);
    --in_work;
    changed.notify_all();
  }

  /// Prepares the frames whose turn it is, unless another thread does.
  void prepare_loaded(std::unique_lock<std::mutex>& lock) {
    if (is_preparing) return;
    is_preparing = true;
    for (; !is_stopped && to_prepare < to_load && slot_of(to_prepare).is_loaded; ++to_prepare) {
      Slot& slot{slot_of(to_prepare)};
      lock.unlock();
      apply(prepare, slot);
      lock.lock();
      slot.is_ready = true;
      changed.notify_all();
    }
    is_preparing = false;
  }

  void work() {
    std::unique_lock lock{mutex};
    while (has_space()) load_next(lock);
    --tasks;
  }

  const FrameSource& source;
  const std::size_t last;
  const int most_tasks;
  const Preparation prepare;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Slot> slots;  ///< frame i waits in slot i % size
  std::size_t to_load;
  std::size_t to_prepare;
  std::size_t to_hand_out;
  int tasks{0};    ///< running, or to run once a thread of oneTBB is free
  int in_work{0};  ///< frames
  bool is_preparing{false};
  bool is_stopped{false};
  tbb::task_arena arena{tbb::task_arena::automatic};
};

FrameQueue::FrameQueue(const FrameSource& source, std::size_t first, std::size_t last, std::size_t capacity,
                       int threads, Preparation prepare)
    : state_{std::make_shared<State>(source, first, std::min(last, source.size()), capacity, threads,
                                     std::move(prepare))} {
  const std::lock_guard lock{state_->mutex};
  start_tasks();
}

FrameQueue::~FrameQueue() {
  std::unique_lock lock{state_->mutex};
  state_->is_stopped = true;
  state_->changed.wait(lock, [this] { return state_->in_work == 0; });
}

// A task may begin late, or never in a forked process: it must not need this object.
void FrameQueue::start_tasks() {
  if (!state_->has_space()) return;
  for (; state_->tasks < state_->most_tasks; ++state_->tasks) {
    state_->arena.enqueue([task = std::weak_ptr{state_}] {
      if (const std::shared_ptr state{task.lock()}) state->work();
    });
  }
}

bool FrameQueue::is_ready_within(std::chrono::milliseconds time) {
  std::unique_lock lock{state_->mutex};
  if (state_->to_hand_out >= state_->last) return true;
  const Slot& slot{state_->slot_of(state_->to_hand_out)};
  return state_->changed.wait_for(lock, time, [&slot] { return slot.is_ready; });
}

std::optional<QueuedFrame> FrameQueue::next() {
  std::unique_lock lock{state_->mutex};
  if (state_->to_hand_out >= state_->last) return std::nullopt;
  if (state_->to_load == state_->to_hand_out) state_->load_next(lock);
  Slot& slot{state_->slot_of(state_->to_hand_out)};
  state_->changed.wait(lock, [&slot] { return slot.is_ready; });
  Slot taken{std::exchange(slot, Slot{})};
  ++state_->to_hand_out;
  start_tasks();
  if (taken.failure) std::rethrow_exception(taken.failure);
  return std::move(taken.frame);
}

}  // namespace stereogrid::io
