// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Subset of oneTBB for src/backend/cpu.hpp, sequential, for scripts/check-neon.sh.
#pragma once

#include <cstddef>

namespace tbb {

namespace info {
inline int default_concurrency() {
  return 1;
}
}  // namespace info

template <class Value>
class blocked_range {
 public:
  blocked_range(Value begin, Value end, std::size_t grain) : begin_{begin}, end_{end}, grain_{grain} {}
  [[nodiscard]] Value begin() const { return begin_; }
  [[nodiscard]] Value end() const { return end_; }
  [[nodiscard]] Value grain() const { return static_cast<Value>(grain_); }

 private:
  Value begin_;
  Value end_;
  std::size_t grain_;
};

template <class Value, class Work>
void parallel_for(const blocked_range<Value>& range, const Work& work) {
  for (Value begin{range.begin()}; begin < range.end(); begin += range.grain()) {
    const Value end{begin + range.grain() < range.end() ? begin + range.grain() : range.end()};
    work(blocked_range<Value>{begin, end, 1});
  }
}

template <class Work>
void parallel_for(int begin, int end, const Work& work) {
  for (int i{begin}; i < end; ++i) work(i);
}

class task_arena {
 public:
  static constexpr int automatic{-1};
  explicit task_arena(int) {}
  template <class Work>
  void execute(const Work& work) {
    work();
  }
};

}  // namespace tbb
