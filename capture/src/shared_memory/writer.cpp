// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "shared_memory/layout.hpp"
#include "stereogrid/capture/shared_memory.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::capture {
namespace {

constexpr std::uint32_t slots{4};

[[noreturn]] void fail(const std::string& name) {
  throw DeviceError{"Shared memory " + name + ": " + std::generic_category().message(errno) + "."};
}

}  // namespace

struct SharedPairs::State {
  std::string name;
  std::uint32_t width_px{0};
  std::uint32_t height_px{0};
  std::byte* memory{nullptr};
  std::size_t bytes{0};
  std::uint64_t written{0};
  Image<std::uint8_t> grey{};
};

SharedPairs::SharedPairs(const std::string& name, int width_px, int height_px)
    : state_{std::make_unique<State>(State{shared_name(name)})} {
  const int largest{static_cast<int>(shared_side_max_px)};
  if (std::clamp(width_px, 1, largest) != width_px || std::clamp(height_px, 1, largest) != height_px) {
    throw ConfigError{"Images in shared memory have 1 to 16384 pixels at each side."};
  }
  State& state{*state_};
  state.width_px = static_cast<std::uint32_t>(width_px);
  state.height_px = static_cast<std::uint32_t>(height_px);
  state.bytes = sizeof(SharedHeader) + slots * slot_bytes(state.width_px, state.height_px);
  shm_unlink(state.name.c_str());  // readers of an earlier writer notice that theirs has no name any more
  const int descriptor{shm_open(state.name.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0600)};
  if (descriptor < 0) fail(state.name);
  // takes the memory now: later there would be a signal where there is none left
  const int error{posix_fallocate(descriptor, 0, static_cast<off_t>(state.bytes))};
  void* const mapped{error == 0 ? mmap(nullptr, state.bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0)
                                : MAP_FAILED};
  const int reason{error == 0 ? errno : error};
  close(descriptor);
  if (mapped == MAP_FAILED) {
    shm_unlink(state.name.c_str());
    errno = reason;
    fail(state.name);
  }
  state.memory = static_cast<std::byte*>(mapped);
  SharedHeader header;
  header.width_px = state.width_px;
  header.height_px = state.height_px;
  header.slots = slots;
  std::memcpy(state.memory, &header, sizeof header);
}

SharedPairs::~SharedPairs() {
  munmap(state_->memory, state_->bytes);
  shm_unlink(state_->name.c_str());
}

void SharedPairs::write(const PixelView& left, const PixelView& right, std::int64_t captured_ns) {
  State& state{*state_};
  const std::uint64_t number{++state.written};
  const std::size_t image_bytes{std::size_t{state.width_px} * state.height_px};
  std::byte* const at{state.memory + sizeof(SharedHeader) +
                      (number - 1) % slots * slot_bytes(state.width_px, state.height_px)};
  SharedSlot& slot{*reinterpret_cast<SharedSlot*>(at)};
  for (const PixelView* view : {&left, &right}) {
    if (view->width_px != static_cast<int>(state.width_px) || view->height_px != static_cast<int>(state.height_px)) {
      --state.written;
      throw InputError{"The images of a pair in shared memory are of the size that it was made for."};
    }
  }
  std::atomic_ref{slot.begun}.store(number, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  slot.captured_ns = captured_ns;
  std::byte* to{at + sizeof(SharedSlot)};
  for (const PixelView* view : {&left, &right}) {
    assign(state.grey, *view);
    std::memcpy(to, state.grey.data(), image_bytes);
    to += image_bytes;
  }
  std::atomic_ref{slot.finished}.store(number, std::memory_order_release);
  SharedHeader& header{*reinterpret_cast<SharedHeader*>(state.memory)};
  std::atomic_ref{header.written}.store(number, std::memory_order_release);
}

}  // namespace stereogrid::capture
