// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/context/fiber.hpp>
#include <boost/context/preallocated.hpp>
#include <cstddef>
#include <functional>
#include <memory>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif

namespace emulator {

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

}  // namespace emulator
