// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <atomic>
#include <latch>
#include <string>
#include <system_error>
#include <thread>
#include <typeinfo>
#include <vector>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

// All at a time.
void start_threads(int count) {
  std::latch all_started{1};
  std::vector<std::jthread> threads;
  struct Release {
    std::latch& latch;
    ~Release() { latch.count_down(); }
  } const release{all_started};  // destroyed before `threads`, which joins
  threads.reserve(static_cast<std::size_t>(count));
  for (int i{0}; i < count; ++i) threads.emplace_back([&] { all_started.wait(); });
}

}  // namespace

void require_threads(int count) {
  static std::atomic_bool has_succeeded{false};
  if (has_succeeded || count <= 0) return;
  try {
    start_threads(count);
  } catch (const std::system_error& error) {
    rethrow_as_device_error(error);
  }
  has_succeeded = true;
}

void rethrow_as_device_error(const std::runtime_error& error) {
  const bool is_of_a_thread{typeid(error) == typeid(std::runtime_error) || typeid(error) == typeid(std::system_error)};
  if (!is_of_a_thread) throw;
  throw DeviceError{
      std::string{"a thread cannot be started: "} + error.what() +
      ". Allow more threads or address space (ulimit -u, ulimit -v, the container's limits), or use fewer "
      "threads."};
}

}  // namespace stereogrid
