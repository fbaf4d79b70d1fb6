// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matching/model.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// Candidates of one hypothesis along an image row, an array per member.
class CandidateRow {
 public:
  /// Elements beyond the width that vectors may touch.
  static constexpr std::size_t padding{64};

  CandidateRow() = default;
  explicit CandidateRow(int width)
      : pitch_{static_cast<std::size_t>(width) + padding}, values_(4 * pitch_), shifts_(pitch_) {}

  [[nodiscard]] std::uint16_t* cost() { return values_.data(); }
  [[nodiscard]] std::uint16_t* has_rivals() { return values_.data() + pitch_; }
  [[nodiscard]] std::uint16_t* before() { return values_.data() + 2 * pitch_; }
  [[nodiscard]] std::uint16_t* after() { return values_.data() + 3 * pitch_; }
  [[nodiscard]] std::int16_t* shift() { return shifts_.data(); }
  [[nodiscard]] const std::uint16_t* cost() const { return values_.data(); }
  [[nodiscard]] const std::uint16_t* has_rivals() const { return values_.data() + pitch_; }
  [[nodiscard]] const std::uint16_t* before() const { return values_.data() + 2 * pitch_; }
  [[nodiscard]] const std::uint16_t* after() const { return values_.data() + 3 * pitch_; }
  [[nodiscard]] const std::int16_t* shift() const { return shifts_.data(); }

  [[nodiscard]] Candidate at(int u) const { return {cost()[u], has_rivals()[u], before()[u], after()[u], shift()[u]}; }
  void set(int u, const Candidate& candidate) {
    cost()[u] = candidate.cost;
    has_rivals()[u] = candidate.has_rivals;
    before()[u] = candidate.before;
    after()[u] = candidate.after;
    shift()[u] = candidate.shift;
  }

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(values_, shifts_); }

 private:
  std::size_t pitch_{0};
  std::vector<std::uint16_t> values_;
  std::vector<std::int16_t> shifts_;
};

/// Best labels of both hypotheses along an image row.
struct RowCandidates {
  RowCandidates() = default;
  explicit RowCandidates(int width) : upright{width}, level{width} {}

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(upright, level); }

  CandidateRow upright;
  CandidateRow level;
};

/// Takes the candidates of an image's rows, and may change them; rows come in any order, from several threads.
class CandidateSink {
 public:
  CandidateSink() = default;
  CandidateSink(const CandidateSink&) = delete;
  CandidateSink& operator=(const CandidateSink&) = delete;
  virtual ~CandidateSink() = default;
  virtual void take(int v, RowCandidates& candidates) = 0;
};

}  // namespace stereogrid
