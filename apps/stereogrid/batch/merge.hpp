// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "batch/plan.hpp"
#include "batch/results.hpp"

namespace stereogrid::app::batch {

struct MergeOptions {
  std::filesystem::path out;
  bool allow_missing{false};
  bool runs{false};  ///< also a run's folder for every drive
};

/// Frames of a plan.
struct MergedFrames {
  std::uint64_t planned{0};  ///< frames that the shards write if none is skipped
  std::uint64_t merged{0};
};

/// Merges the results of a plan in the order of its manifest. All files but timing.json have the same bytes whichever
/// runners made the results, when and in which order. Throws InputError: shards are missing (with their numbers) or
/// damaged; ConfigError: the folder is not empty; DeviceError.
MergedFrames merge(const PlanReader& plan, const MergeOptions& options);

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

/// summary.html, without other files: counts, each configuration's figures with intervals, and of a sweep the
/// configurations that are best in missed or false alarms (Pareto front). `summary`: summary.json.
[[nodiscard]] std::string summary_page(const Json& summary);

/// The results of a drive's shards as one run's folder (docs/format.md), which evaluate, export and view read.
class DriveRun {
 public:
  /// Its folder in `runs` has the drive's name, and, of several variants, ".v" and the variant's number.
  DriveRun(const std::filesystem::path& runs, const Shard& first, std::size_t variants);
  /// Appends the next shard's result. Throws InputError, DeviceError.
  void add(const std::filesystem::path& result);
  /// Throws DeviceError.
  void finish();

 private:
  std::filesystem::path folder_;
  std::ofstream lines_;
  Json run_;
};

/// timing.json of a merged folder: the times of a plan's results, by variant and by machine.
class MergedTiming {
 public:
  /// `timing`: a result's timing.json.
  void add(const Shard& shard, const Json& timing);
  [[nodiscard]] Json summary(const Plan& plan) const;

 private:
  struct Sums {
    std::uint64_t shards{0};
    double frames{0};
    double seconds{0};
    std::map<std::string, double> stage_ms;  ///< times frames
  };
  [[nodiscard]] static Json json_of(const Sums& sums);
  static void add(const Json& timing, Sums& sums);

  std::map<std::size_t, Sums> variants_;
  std::map<std::string, Sums> hosts_;
};

}  // namespace stereogrid::app::batch
