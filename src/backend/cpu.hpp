// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <algorithm>
#include <stdexcept>

namespace stereogrid {

/// Throws DeviceError unless the system gives this process `count` more threads. Starts them to find out, until that
/// has succeeded once: oneTBB starts threads from threads of its own, where a failure ends the program.
void require_threads(int count);

/// Within a handler: throws DeviceError for a failure of oneTBB or the standard library to start a thread, and anything
/// else again.
[[noreturn]] void rethrow_as_device_error(const std::runtime_error& error);

/// Threads of the CPU back end, in an arena of its own so that other users of oneTBB in the process are left alone.
class Cpu {
 public:
  /// `threads` 0: as many as the machine has cores. More than that are not started (oneTBB would complain on stderr),
  /// but the work is cut for them. Throws DeviceError: the system has too few threads for this process.
  explicit Cpu(int threads)
      : threads_{threads > 0 ? threads : tbb::info::default_concurrency()},
        arena_{std::min(threads_, tbb::info::default_concurrency())} {
    require_threads(std::min(threads_, tbb::info::default_concurrency()) - 1);
  }

  [[nodiscard]] int threads() const { return threads_; }

  /// Calls work(begin, end) on disjoint parts of [0, count) of at least `grain` elements. Results must not depend on
  /// how it is cut.
  template <class Work>
  void for_ranges(int count, int grain, const Work& work) {
    execute([&] {
      tbb::parallel_for(tbb::blocked_range<int>{0, count, static_cast<std::size_t>(grain)},
                        [&](const tbb::blocked_range<int>& part) { work(part.begin(), part.end()); });
    });
  }

  /// Calls both, at the same time if there is a thread for it.
  template <class First, class Second>
  void together(const First& first, const Second& second) {
    execute([&] { tbb::parallel_for(0, 2, [&](int which) { which == 0 ? first() : second(); }); });
  }

  /// Calls work(part, begin, end) with [0, count) cut into `parts` equal pieces.
  template <class Work>
  void for_parts(int count, int parts, const Work& work) {
    execute([&] {
      tbb::parallel_for(0, parts, [&](int part) {
        work(part, static_cast<int>(static_cast<long>(count) * part / parts),
             static_cast<int>(static_cast<long>(count) * (part + 1) / parts));
      });
    });
  }

 private:
  // oneTBB starts its threads at the first work for them.
  template <class Work>
  void execute(const Work& work) {
    try {
      arena_.execute(work);
    } catch (const std::runtime_error& error) {
      rethrow_as_device_error(error);
    }
  }

  int threads_;
  tbb::task_arena arena_;
};

/// for_ranges(count, work) of stages that do not name the threads: parts of 8 elements or more.
inline auto ranges_of(Cpu& cpu) {
  return [&cpu](int count, const auto& work) { cpu.for_ranges(count, 8, work); };
}

}  // namespace stereogrid
