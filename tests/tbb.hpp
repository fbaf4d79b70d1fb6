// SPDX-License-Identifier: Apache-2.0
//
// Subset of oneTBB for this project, on plain threads: for ARM without the library, and for the thread sanitizer, which
// does not cover the synchronisation of a library that it has not compiled, and would report every loop as a race.
// Results are equal.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

namespace tbb {

namespace info {
/// More than some machines have, so that threads meet there, too.
inline int default_concurrency() {
  return 4;
}
}  // namespace info

namespace stand_in {

/// Parts [0, count) of a loop, handed out one by one.
struct Loop {
  int count;
  int helpers_wanted;
  const std::function<void(int)>& work;
  int next{0};
  int helpers{0};
  std::exception_ptr failure{};
};

class Pool {
 public:
  static Pool& instance() {
    static Pool pool;
    return pool;
  }

  /// Calls work(i) for [0, count) on the calling thread and on up to `helpers` others.
  void run(int count, int helpers, const std::function<void(int)>& work) {
    Loop loop{count, std::min(helpers, count - 1), work};
    std::unique_lock lock{mutex_};
    loops_.push_back(&loop);
    changed_.notify_all();
    take_parts(loop, lock);
    loops_.remove(&loop);
    changed_.wait(lock, [&] { return loop.helpers == 0; });
    if (loop.failure) std::rethrow_exception(loop.failure);
  }

 private:
  Pool() {
    for (int i{1}; i < info::default_concurrency(); ++i) threads_.emplace_back([this] { help(); });
  }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool() {
    {
      const std::lock_guard lock{mutex_};
      ended_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  static void take_parts(Loop& loop, std::unique_lock<std::mutex>& lock) {
    while (loop.next < loop.count && !loop.failure) {
      const int part{loop.next++};
      lock.unlock();
      std::exception_ptr failure;
      try {
        loop.work(part);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      if (failure) loop.failure = failure;
    }
  }

  void help() {
    std::unique_lock lock{mutex_};
    for (;;) {
      const auto in_need = [](const Loop* loop) {
        return loop->next < loop->count && loop->helpers < loop->helpers_wanted;
      };
      changed_.wait(lock, [&] { return ended_ || std::any_of(loops_.begin(), loops_.end(), in_need); });
      if (ended_) return;
      Loop& loop{**std::find_if(loops_.begin(), loops_.end(), in_need)};
      ++loop.helpers;
      take_parts(loop, lock);
      --loop.helpers;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Loop*> loops_;
  bool ended_{false};
  std::vector<std::thread> threads_;
};

/// Concurrency of the calling thread's arena.
inline int& concurrency() {
  thread_local int threads{info::default_concurrency()};
  return threads;
}

}  // namespace stand_in

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

template <class Work>
void parallel_for(int begin, int end, const Work& work) {
  if (end <= begin) return;
  stand_in::Pool::instance().run(end - begin, stand_in::concurrency() - 1, [&](int i) { work(begin + i); });
}

template <class Value, class Work>
void parallel_for(const blocked_range<Value>& range, const Work& work) {
  const Value grain{std::max(range.grain(), Value{1})};
  parallel_for(0, static_cast<int>((range.end() - range.begin() + grain - 1) / grain), [&](int i) {
    const Value begin{range.begin() + static_cast<Value>(i) * grain};
    work(blocked_range<Value>{begin, std::min(begin + grain, range.end()), 1});
  });
}

class task_arena {
 public:
  static constexpr int automatic{-1};
  explicit task_arena(int threads) : threads_{threads > 0 ? threads : info::default_concurrency()} {}

  template <class Work>
  void execute(const Work& work) {
    int& here{stand_in::concurrency()};
    const Entered entered{here, here};
    here = threads_;
    work();
  }

 private:
  struct Entered {
    int& here;
    int before;
    Entered(int& place, int value) : here{place}, before{value} {}
    Entered(const Entered&) = delete;
    Entered& operator=(const Entered&) = delete;
    ~Entered() { here = before; }
  };

  int threads_;
};

}  // namespace tbb
