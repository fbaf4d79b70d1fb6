// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <thread>

#include "backend/cpu.hpp"
#include "matching/semi_global/paths_simd.hpp"
#include "matching/semi_global/semi_global.hpp"

namespace stereogrid {

LabelLayout::LabelLayout(Shifts upright)
    : uprights{(upright.count + block - 1) / block * block},
      upright_at{uprights - upright.count},
      road_at{uprights + guard},
      stride{uprights + block} {}

namespace {

// Hands out aligned pieces of a memory; without one it only measures.
class Pieces {
 public:
  static constexpr std::size_t alignment{64};

  explicit Pieces(std::uint8_t* memory) : memory_{memory} {}

  template <class T>
  T* take(std::size_t count) {
    const std::size_t start{used_};
    used_ += (count * sizeof(T) + alignment - 1) / alignment * alignment;
    return memory_ == nullptr ? nullptr : reinterpret_cast<T*>(memory_ + start);
  }
  [[nodiscard]] std::size_t used() const { return used_; }

 private:
  std::uint8_t* memory_;
  std::size_t used_{0};
};

class SemiGlobal {
 public:
  SemiGlobal(const SemiGlobalTask& task, int threads) : task_{task}, threads_{threads} {}

  [[nodiscard]] std::size_t needed() {
    Pieces measure{nullptr};
    take_memory(measure);
    return measure.used() + Pieces::alignment;
  }

  /// `memory`: as much as is needed; `rows`: one for each thread.
  void run(Cpu& cpu, std::uint8_t* memory, std::vector<RowCandidates>& rows) {
    Pieces pieces{memory + (Pieces::alignment - reinterpret_cast<std::uintptr_t>(memory) % Pieces::alignment)};
    take_memory(pieces);
    for (std::size_t i{0}; i < room_count(); ++i) rooms_[i].candidates = &rows[i / group];
    sweep(cpu);
  }

 private:
  [[nodiscard]] int width() const { return task_.census.left.width; }
  [[nodiscard]] int height() const { return task_.census.left.height; }

  [[nodiscard]] std::size_t room_count() const { return static_cast<std::size_t>(threads_) * group; }

  void take_memory(Pieces& pieces) {
    const LabelLayout& layout{task_.layout};
    const auto stride = static_cast<std::size_t>(layout.stride);
    const auto row = static_cast<std::size_t>(width());
    rooms_ = pieces.take<SemiGlobalRoom>(room_count());
    passed_ = pieces.take<std::atomic<int>>(static_cast<std::size_t>(height()));
    first_ = pieces.take<std::uint8_t>(stride);
    pieces.take<std::uint8_t>(LabelLayout::guard);  // looked at beside the first pixel, and beside the last one
    task_.vertical = pieces.take<std::uint8_t>(row * stride + LabelLayout::guard);
    for (std::size_t i{0}; i < room_count(); ++i) {
      const SemiGlobalRoom room{take_room(pieces)};
      if (rooms_ != nullptr) rooms_[i] = room;
    }
  }

  SemiGlobalRoom take_room(Pieces& pieces) const {
    const auto stride = static_cast<std::size_t>(task_.layout.stride);
    const auto row = static_cast<std::size_t>(width());
    const std::size_t reach{row + stride};
    SemiGlobalRoom room{};
    for (std::uint8_t*& plane : room.right) plane = pieces.take<std::uint8_t>(reach);
    for (std::uint8_t*& plane : room.sheared) plane = pieces.take<std::uint8_t>(reach);
    room.closed = pieces.take<std::uint8_t>(stride);
    room.carry = pieces.take<std::uint8_t>(stride);
    room.costs = pieces.take<std::uint8_t>(row * stride);
    room.sums = pieces.take<std::uint8_t>(row * stride);
    room.meeting = pieces.take<std::int32_t>(row);
    take_choice(pieces, room.upright);
    take_choice(pieces, room.road);
    if (room.closed != nullptr) close_guards(room.closed);
    return room;
  }

  void take_choice(Pieces& pieces, RowChoice& choice) const {
    const std::size_t row{static_cast<std::size_t>(width() + LabelLayout::block)};
    choice.key = pieces.take<std::uint16_t>(row);
    choice.runner_up = pieces.take<std::uint8_t>(row);
    choice.before = pieces.take<std::uint8_t>(row);
    choice.after = pieces.take<std::uint8_t>(row);
  }

  void close_guards(std::uint8_t* closed) const {
    const LabelLayout& layout{task_.layout};
    std::memset(closed, cost_max, static_cast<std::size_t>(layout.stride));
    std::memset(closed + layout.upright_at, 0, static_cast<std::size_t>(task_.upright.count));
    std::memset(closed + layout.road_at, 0, static_cast<std::size_t>(task_.road.count));
  }

  // Paths begin without costs, at the last row.
  void start_sweep() {
    const auto stride = static_cast<std::size_t>(task_.layout.stride);
    std::copy_n(rooms_[0].closed, stride, first_);
    if (!row_has_road(task_.plane, width(), height() - 1)) {
      std::fill(first_ + task_.layout.uprights, first_ + stride, std::uint8_t{cost_max});
    }
    task_.vertical[-1] = task_.vertical[at(width())] = cost_max;
    for (int u{0}; u < width(); ++u) std::copy_n(first_, stride, task_.vertical + at(u));
  }
  [[nodiscard]] std::ptrdiff_t at(int u) const { return static_cast<std::ptrdiff_t>(u) * task_.layout.stride; }

  // Groups of rows in order, each taken by the first idle thread. A group follows the one before at a distance; the
  // owner of that one is already running, so no thread waits for ever. Rows are grouped because passing data between
  // cores is expensive.
  void sweep(Cpu& cpu) {
    start_sweep();
    std::uninitialized_value_construct_n(passed_, height());
    std::atomic<int> next{0};
    cpu.for_parts(threads_, threads_, [&](int thread, int, int) {
      const SemiGlobalRoom* const rooms{&rooms_[static_cast<std::size_t>(thread * group)]};
      for (int first{next.fetch_add(group)}; first < height(); first = next.fetch_add(group)) {
        const int count{std::min(group, height() - first)};
        for (int row{0}; row < count; ++row) semi_global_start_row(task_, rooms[row], row_at(first + row));
        group_forward(first, count, rooms);
        for (int row{0}; row < count; ++row) semi_global_backward(task_, rooms[row], row_at(first + row));
      }
    });
  }

  // Each row one part of the columns behind the row before.
  void group_forward(int first, int count, const SemiGlobalRoom* rooms) {
    const int parts{(width() + columns_grain - 1) / columns_grain};
    for (int step{0}; step < parts + count - 1; ++step) {
      for (int row{std::max(0, step - parts + 1)}; row < std::min(count, step + 1); ++row) {
        const int i{first + row};
        const int begin{(step - row) * columns_grain};
        const int end{std::min(begin + columns_grain, width())};
        if (i > 0) wait_for(passed_[i - 1], std::min(end + 1, width()));
        semi_global_forward(task_, rooms[row], row_at(i), begin, end);
        passed_[i].store(end, std::memory_order_release);
      }
    }
  }
  [[nodiscard]] int row_at(int i) const { return height() - 1 - i; }

  static void wait_for(const std::atomic<int>& passed, int columns) {
    while (passed.load(std::memory_order_acquire) < columns) std::this_thread::yield();
  }

  static constexpr int columns_grain{64};
  static constexpr int group{2};

  SemiGlobalTask task_;
  int threads_;
  SemiGlobalRoom* rooms_{nullptr};
  std::atomic<int>* passed_{nullptr};  // [i] columns of the i-th row from below that are done
  std::uint8_t* first_{nullptr};       // input of the last row's pixels from below
};

SemiGlobalTask task_of(const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config) {
  SemiGlobalTask task{census, plane, upright_shifts(config), road_shifts, LabelLayout{upright_shifts(config)}};
  task.uniqueness_1024 = uniqueness_1024(config);
  return task;
}

}  // namespace

std::size_t optimise_memory(int width, int height, const MatchingConfig& config, int threads) {
  const View<const std::uint32_t> image{nullptr, width, height, width};
  return SemiGlobal{task_of({image, image, image}, {}, config), threads}.needed();
}

void optimise(Cpu& cpu, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              std::vector<std::uint8_t>& memory, std::vector<RowCandidates>& rows, CandidateSink& sink) {
  SemiGlobalTask task{task_of(census, plane, config)};
  task.sink = &sink;
  SemiGlobal optimisation{task, static_cast<int>(rows.size())};
  memory.resize(std::max(memory.size(), optimisation.needed()));
  optimisation.run(cpu, memory.data(), rows);
}

}  // namespace stereogrid
