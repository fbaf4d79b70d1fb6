// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "../temporary_folder.hpp"
#include "batch/plan.hpp"
#include "batch/sha256.hpp"

namespace stereogrid::app::batch::testing {

namespace fs = std::filesystem;

/// A folder of its own for each test, removed afterwards.
class Folder : public ::testing::Test, protected tests::TemporaryFolder {};

/// A plan of one configuration, for drives of any kind.
inline Plan simple_plan() {
  Plan plan;
  plan.version = "1";
  plan.memory_mb = 300;
  plan.run = {{"device", "cpu"}};
  plan.variants = {{{}, {"grid.length_m=30"}, Json{{"grid", {{"length_m", 30}}}}}};
  return plan;
}

inline Shard simple_shard(std::size_t first, std::size_t end) {
  Shard shard;
  shard.drive = "drive";
  shard.input = {"scene:street"};
  shard.input_digest = sha256_of("street");
  shard.first = first;
  shard.end = end;
  shard.cost = static_cast<double>(end - first) * 100;
  return shard;
}

/// Writes a plan of `shards` shards of ten frames.
inline Plan write_plan(const fs::path& folder, std::size_t shards) {
  Plan plan{simple_plan()};
  PlanWriter writer{folder};
  for (std::size_t i{0}; i < shards; ++i) writer.add(simple_shard(10 * i, 10 * i + 10), plan);
  plan.drives = 1;
  writer.finish(plan);
  return plan;
}

}  // namespace stereogrid::app::batch::testing
