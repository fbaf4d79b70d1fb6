// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

class Transfer;

/// The input of a shard, compared with the digest that the plan has of it.
class PlannedInput {
 public:
  /// `transfer`: fetches inputs; nullptr: they are where the plan says. All arguments have to live longer.
  PlannedInput(const PlanReader& plan, const Shard& shard, Transfer* transfer)
      : plan_{plan}, shard_{shard}, transfer_{transfer} {}

  /// The first path that does not exist, or is an empty folder such as an unused mount point; "": none.
  [[nodiscard]] std::string missing() const;
  /// Fetches the input; a damaged copy is fetched again. Throws DeviceError.
  void fetch();
  /// Whether names, sizes and contents are those of the plan. Throws DeviceError: a file cannot be read.
  [[nodiscard]] bool is_as_planned() const { return is_as_planned(copies_); }
  /// The same, and false for an input that is missing or cannot be read.
  [[nodiscard]] bool is_there() const;
  /// Copies that were fetched, by the paths that they stand for.
  [[nodiscard]] const std::map<std::string, std::string>& copies() const { return copies_; }

 private:
  [[nodiscard]] bool is_as_planned(const std::map<std::string, std::string>& copies) const;

  const PlanReader& plan_;
  const Shard& shard_;
  Transfer* transfer_;
  std::map<std::string, std::string> copies_;
};

}  // namespace stereogrid::app::batch
