// SPDX-License-Identifier: Apache-2.0
//
// Subset of oneTBB for this project, on one thread.
#ifndef STEREOGRID_PLAYGROUND_TBB
#define STEREOGRID_PLAYGROUND_TBB

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
  blocked_range(Value begin, Value end, std::size_t /*grain*/) : begin_{begin}, end_{end} {}
  [[nodiscard]] Value begin() const { return begin_; }
  [[nodiscard]] Value end() const { return end_; }

 private:
  Value begin_;
  Value end_;
};

template <class Work>
void parallel_for(int begin, int end, const Work& work) {
  for (int i{begin}; i < end; ++i) work(i);
}

template <class Value, class Work>
void parallel_for(const blocked_range<Value>& range, const Work& work) {
  if (range.begin() < range.end()) work(range);
}

class task_arena {
 public:
  explicit task_arena(int /*threads*/) {}
  template <class Work>
  void execute(const Work& work) {
    work();
  }
};

}  // namespace tbb

#endif
