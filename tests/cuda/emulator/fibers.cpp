// SPDX-License-Identifier: Apache-2.0
#include "fibers.hpp"

#include <algorithm>
#include <boost/context/fiber.hpp>
#include <boost/context/preallocated.hpp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif

namespace emulator {
namespace {

/// A stack of its own on which `work` runs again and again: once per round, and a round may be left and entered in the
/// middle.
class Fiber {
 public:
  explicit Fiber(std::function<void()> work)
      : work_{std::move(work)},
        stack_{std::make_unique<std::byte[]>(stack_bytes)},
        inside_{std::allocator_arg, preallocated(), NoOwner{}, [this](boost::context::fiber&& caller) {
                  outside_ = std::move(caller);
                  arrived(nullptr);
                  for (;;) {
                    work_();
                    leave();
                  }
                  return std::move(outside_);
                }} {}

  /// Starts or continues a round from outside, until it ends or leaves.
  void enter() {
#if defined(__SANITIZE_ADDRESS__)
    void* own{nullptr};
    __sanitizer_start_switch_fiber(&own, stack_.get(), stack_bytes);
#endif
    inside_ = std::move(inside_).resume();
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_finish_switch_fiber(own, nullptr, nullptr);
#endif
  }

  /// From inside: back to where enter() was called.
  void leave() {
    void* own{nullptr};
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_start_switch_fiber(&own, outside_stack_, outside_bytes_);
#endif
    outside_ = std::move(outside_).resume();
    arrived(own);
  }

 private:
  struct NoOwner {
    static void deallocate(boost::context::stack_context& /*stack*/) {}
  };
#if defined(__SANITIZE_ADDRESS__)
  static constexpr std::size_t stack_bytes{std::size_t{256} << 10};
#else
  static constexpr std::size_t stack_bytes{std::size_t{64} << 10};
#endif

  boost::context::preallocated preallocated() {
    boost::context::stack_context context;
    context.size = stack_bytes;
    context.sp = stack_.get() + stack_bytes;
    return {context.sp, context.size, context};
  }

  // Notifies the address sanitizer of the stack in use.
  void arrived([[maybe_unused]] void* own) {
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_finish_switch_fiber(own, &outside_stack_, &outside_bytes_);
#endif
  }

  std::function<void()> work_;
  std::unique_ptr<std::byte[]> stack_;
  boost::context::fiber outside_;
  boost::context::fiber inside_;
#if defined(__SANITIZE_ADDRESS__)
  const void* outside_stack_{nullptr};
  std::size_t outside_bytes_{0};
#endif
};

enum class State { ready, at_block_barrier, at_warp_operation, done };

struct Thread {
  std::unique_ptr<Fiber> fiber;
  State state{State::done};
  unsigned mask{0};
  std::uint64_t value{0};
  int source_lane{0};
  WarpOperation operation{WarpOperation::nothing};
  std::uint64_t result{0};
};

constexpr std::uint64_t undefined{0xA5A5A5A5A5A5A5A5U};

[[noreturn]] void fail(const char* what, int thread) {
  std::fprintf(stderr, "emulator: block (%u, %u, %u), thread %d: %s\n", blockIdx.x, blockIdx.y, blockIdx.z, thread,
               what);
  std::abort();
}

/// The threads of one block.
class Block {
 public:
  void run(int threads, std::size_t shared_bytes, const std::function<void()>& kernel, bool backwards) {
    count_ = threads;
    alive_ = threads;
    at_barrier_ = 0;
    kernel_ = &kernel;
    shared_.resize(shared_bytes / sizeof(std::max_align_t) + 1);
    fill_unwritten(shared_.data(), shared_.size() * sizeof(std::max_align_t), unwritten);
    while (static_cast<int>(threads_.size()) < threads) add_thread();
    for (int i{0}; i < threads; ++i) threads_[static_cast<std::size_t>(i)].state = State::ready;
    while (alive_ > 0) pass(backwards);
  }

  void barrier() {
    ++at_barrier_;
    me().state = State::at_block_barrier;
    if (!release_barrier()) me().fiber->leave();
  }

  std::uint64_t exchange(unsigned mask, std::uint64_t value, int source_lane, WarpOperation operation) {
    Thread& self{me()};
    if ((mask >> lane() & 1U) == 0) fail("is not in the mask of its own warp operation", current_);
    self.mask = mask;
    self.value = value;
    self.source_lane = source_lane;
    self.operation = operation;
    self.state = State::at_warp_operation;
    if (!release_warp(current_)) self.fiber->leave();
    return self.result;
  }

  [[nodiscard]] int lane() const { return current_ % warpSize; }
  void* shared() { return shared_.data(); }

 private:
  Thread& me() { return threads_[static_cast<std::size_t>(current_)]; }

  void add_thread() {
    Thread thread;
    thread.fiber = std::make_unique<Fiber>([this] {
      (*kernel_)();
      end_thread();
    });
    threads_.push_back(std::move(thread));
  }

  void end_thread() {
    me().state = State::done;
    --alive_;
    release_barrier();
    const int first{current_ / warpSize * warpSize};
    for (int i{first}; i < std::min(first + warpSize, count_); ++i) {
      if (threads_[static_cast<std::size_t>(i)].state == State::at_warp_operation) release_warp(i);
    }
  }

  void pass(bool backwards) {
    bool is_stuck{true};
    for (int k{0}; k < count_; ++k) {
      current_ = backwards ? count_ - 1 - k : k;
      if (me().state != State::ready) continue;
      is_stuck = false;
      const auto i{static_cast<unsigned>(current_)};
      threadIdx = {i % blockDim.x, i / blockDim.x % blockDim.y, i / blockDim.x / blockDim.y};
      me().fiber->enter();
    }
    if (is_stuck) report_stuck();
  }

  // Threads that have ended count as arrived, as on the device.
  bool release_barrier() {
    if (at_barrier_ == 0 || at_barrier_ < alive_) return false;
    at_barrier_ = 0;
    for (int i{0}; i < count_; ++i) {
      Thread& thread{threads_[static_cast<std::size_t>(i)]};
      if (thread.state == State::at_block_barrier) thread.state = State::ready;
    }
    return true;
  }

  // True if all participants of thread `one`'s operation have arrived. Then all of them get their results.
  bool release_warp(int one) {
    const Thread& model{threads_[static_cast<std::size_t>(one)]};
    const unsigned mask{model.mask};
    const WarpOperation operation{model.operation};
    Thread* const warp{&threads_[static_cast<std::size_t>(one / warpSize * warpSize)]};
    const int lanes{std::min(warpSize, count_ - one / warpSize * warpSize)};
    unsigned present{0};
    std::uint64_t ballot{0};
    for (int i{0}; i < lanes; ++i) {
      if ((mask >> i & 1U) == 0 || warp[i].state == State::done) continue;
      const bool is_there{warp[i].state == State::at_warp_operation && warp[i].mask == mask &&
                          warp[i].operation == operation};
      if (!is_there) return false;
      present |= 1U << i;
      ballot |= warp[i].value << i;
    }
    for (int i{0}; i < lanes; ++i) {
      if ((present >> i & 1U) == 0) continue;
      const bool is_defined{(present >> warp[i].source_lane & 1U) != 0};
      warp[i].result = operation == WarpOperation::ballot ? ballot
                       : is_defined                       ? warp[warp[i].source_lane].value
                                                          : undefined;
      warp[i].state = State::ready;
    }
    return true;
  }

  [[noreturn]] void report_stuck() {
    for (int i{0}; i < count_; ++i) {
      const State state{threads_[static_cast<std::size_t>(i)].state};
      if (state == State::at_warp_operation) fail("waits for lanes that never come to this warp operation", i);
    }
    fail("waits at a barrier that others never come to", 0);
  }

  std::vector<Thread> threads_;
  std::vector<std::max_align_t> shared_;
  const std::function<void()>* kernel_{nullptr};
  int count_{0};
  int alive_{0};
  int at_barrier_{0};
  int current_{0};
};

// Never destroyed: its fibers end with the program.
Block& block() {
  static Block& the_block{*new Block};
  return the_block;
}

}  // namespace

void fill_unwritten(void* memory, std::size_t bytes, std::uint32_t word) {
  for (std::size_t i{0}; i < bytes; i += sizeof word) {
    std::memcpy(static_cast<std::byte*>(memory) + i, &word, std::min(bytes - i, sizeof word));
  }
}

void run_grid(dim3 grid, dim3 threads, std::size_t shared_bytes, const std::function<void()>& kernel, bool backwards) {
  gridDim = grid;
  blockDim = threads;
  const unsigned blocks{grid.x * grid.y * grid.z};
  for (unsigned k{0}; k < blocks; ++k) {
    const unsigned i{backwards ? blocks - 1 - k : k};
    blockIdx = {i % grid.x, i / grid.x % grid.y, i / grid.x / grid.y};
    block().run(static_cast<int>(threads.x * threads.y * threads.z), shared_bytes, kernel, backwards);
  }
}

void* dynamic_shared() {
  return block().shared();
}
void block_barrier() {
  block().barrier();
}
std::uint64_t warp_exchange(unsigned mask, std::uint64_t value, int source_lane, WarpOperation operation) {
  return block().exchange(mask, value, source_lane, operation);
}
int lane() {
  return block().lane();
}

}  // namespace emulator
