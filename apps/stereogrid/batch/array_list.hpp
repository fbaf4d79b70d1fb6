// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stereogrid::app::batch {

/// Numbers from `first` to `last`, both included.
struct NumberRange {
  std::uint64_t first{0};
  std::uint64_t last{0};

  friend bool operator==(const NumberRange&, const NumberRange&) = default;
};

/// Numbers as Slurm's --array has them ("3-7,12"), which come in growing order.
class ArrayList {
 public:
  void add(std::uint64_t number);
  [[nodiscard]] const std::vector<NumberRange>& ranges() const { return ranges_; }
  [[nodiscard]] std::string text() const;

 private:
  std::vector<NumberRange> ranges_;
};

/// Reads "3-7,12"; all below `end`. Throws ConfigError.
[[nodiscard]] std::vector<NumberRange> parse_array_list(const std::string& text, std::uint64_t end);

}  // namespace stereogrid::app::batch
