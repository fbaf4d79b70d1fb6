// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/frame_queue.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

struct Slot {
  bool ready{false};
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
  slot.ready = true;
  slot.frame.index = index;
  guarded(slot, [&](QueuedFrame& frame) {
    frame.name = source.name(index);
    frame.frame = source.load(index);
    if (!frame.frame->fault.empty()) frame.warning = frame.frame->fault;
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
  State(const FrameSource& frame_source, std::size_t first, std::size_t end, std::size_t capacity,
        Preparation preparation)
      : source{frame_source},
        last{end},
        prepare{std::move(preparation)},
        slots(std::max<std::size_t>(1, capacity)),
        to_load{first},
        to_prepare{first},
        to_hand_out{first} {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    request_stop();
    for (std::thread& thread : threads) thread.join();
  }

  void request_stop() {
    const std::lock_guard lock{mutex};
    stop = true;
    space.notify_all();
    turn.notify_all();
  }

  void work() {
    load_frames();
    const std::lock_guard lock{mutex};
    --working;
    filled.notify_all();
  }

  void load_frames() {
    std::unique_lock lock{mutex};
    for (;;) {
      space.wait(lock, [this] { return stop || to_load >= last || to_load < to_hand_out + slots.size(); });
      if (stop || to_load >= last) return;
      const std::size_t index{to_load++};
      lock.unlock();
      Slot slot{load(source, index)};
      lock.lock();
      turn.wait(lock, [this, index] { return stop || to_prepare == index; });
      if (stop) return;
      lock.unlock();
      apply(prepare, slot);
      lock.lock();
      ++to_prepare;
      slots[index % slots.size()] = std::move(slot);
      turn.notify_all();
      filled.notify_one();
    }
  }

  const FrameSource& source;
  const std::size_t last;
  const Preparation prepare;
  std::mutex mutex;
  std::condition_variable space;
  std::condition_variable turn;
  std::condition_variable filled;
  std::vector<Slot> slots;  ///< frame i waits in slot i % size
  std::size_t to_load;
  std::size_t to_prepare;
  std::size_t to_hand_out;
  bool stop{false};
  int working{0};  ///< threads
  std::vector<std::thread> threads;
};

FrameQueue::FrameQueue(const FrameSource& source, std::size_t first, std::size_t last, std::size_t capacity,
                       int threads, Preparation prepare)
    : state_{std::make_unique<State>(source, first, std::min(last, source.size()), capacity, std::move(prepare))} {
  const int count{std::max(1, threads)};
  state_->working = count;
  for (int i{0}; i < count; ++i) state_->threads.emplace_back([this] { state_->work(); });
}

FrameQueue::~FrameQueue() = default;

bool FrameQueue::stop_within(std::chrono::milliseconds time) {
  state_->request_stop();
  std::unique_lock lock{state_->mutex};
  return state_->filled.wait_for(lock, time, [this] { return state_->working == 0; });
}

bool FrameQueue::is_ready_within(std::chrono::milliseconds time) {
  std::unique_lock lock{state_->mutex};
  if (state_->to_hand_out >= state_->last) return true;
  const Slot& slot{state_->slots[state_->to_hand_out % state_->slots.size()]};
  return state_->filled.wait_for(lock, time, [&slot] { return slot.ready; });
}

std::optional<QueuedFrame> FrameQueue::next() {
  std::unique_lock lock{state_->mutex};
  if (state_->to_hand_out >= state_->last) return std::nullopt;
  Slot& slot{state_->slots[state_->to_hand_out % state_->slots.size()]};
  state_->filled.wait(lock, [&slot] { return slot.ready; });
  Slot taken{std::exchange(slot, Slot{})};
  ++state_->to_hand_out;
  state_->space.notify_all();
  if (taken.failure) std::rethrow_exception(taken.failure);
  return std::move(taken.frame);
}

}  // namespace stereogrid::io
