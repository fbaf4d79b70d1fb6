// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// A figure of `evaluate`, and how many frames it is of.
struct Figure {
  double value{0};
  double frames{0};
};
/// By name: "occupancy.3-20.missed", "occupancy.motion.ghost_s", "obstacles.found".
using Figures = std::map<std::string, Figure>;

/// The single numbers of what `stereogrid evaluate --json` writes; those that are null are left out. `frames`: scored.
[[nodiscard]] Figures figures_of(const Json& evaluation, double frames);

[[nodiscard]] Json to_json(const Figures& figures);
[[nodiscard]] Figures figures_in(const Json& json);

/// Adds a part of a drive: means weighted by frames.
void add_part(Figures& drive, const Figures& part);

/// A mean over drives with its 95 % interval; low > high: too few drives for one.
struct FigureOverDrives {
  double value{0};
  double low{1};
  double high{0};
  std::uint64_t drives{0};
};

/// Figures of many drives, each of which counts once, in bounded memory. Intervals: drives drawn with replacement,
/// always by the same draws; of more than 2000 drives ±1.96 standard errors.
class FiguresOverDrives {
 public:
  void add(const Figures& drive);
  [[nodiscard]] std::map<std::string, FigureOverDrives> means() const;

 private:
  static constexpr std::size_t most_kept{2000};
  struct Sums {
    std::uint64_t drives{0};
    double sum{0};
    double sum_of_squares{0};
    std::vector<double> kept;
  };
  std::map<std::string, Sums> sums_;
};

}  // namespace stereogrid::app::batch
