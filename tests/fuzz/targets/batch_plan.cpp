// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "batch/plan.hpp"
#include "batch/results.hpp"
#include "targets.hpp"

namespace stereogrid::fuzz {
namespace {

namespace batch = app::batch;

/// Index of the lines of a manifest, as PlanWriter writes it.
std::string index_of(std::string_view manifest) {
  std::string index;
  const auto add = [&index](std::size_t offset) {
    for (int byte{0}; byte < 8; ++byte) index += static_cast<char>(offset >> (8 * byte) & 0xff);
  };
  add(0);
  for (std::size_t at{manifest.find('\n')}; at != std::string_view::npos; at = manifest.find('\n', at + 1)) add(at + 1);
  return index;
}

void read_plan(const Folder& folder) {
  const batch::PlanReader plan{folder.path()};
  std::uint64_t shards{0};
  accepts([&] {
    plan.for_each([&shards](const batch::Shard& shard) {
      require(shard.number == shards++, "shards out of order");
      require(shard.first < shard.end && !shard.input.empty(), "a shard without frames or input");
      require(batch::shard_of(batch::to_json(shard)) == shard, "a shard that is another one when it is read again");
    });
  });
  for (std::uint64_t number{0}; number <= shards; ++number) {
    accepts([&] { require(plan.shard(number).number == number, "another shard than asked for"); });
  }
}

}  // namespace

void batch_plan(Bytes input) {
  static const Folder folder;
  const auto files{parts_of(input, 2)};
  folder.write("plan.json", files[0]);
  folder.write("manifest.jsonl", files[1]);
  folder.write("manifest.index", index_of(files[1]));
  accepts([&] { read_plan(folder); });
}

void batch_result(Bytes input) {
  static const Folder folder;
  const auto files{parts_of(input, 2)};
  folder.write("done.json", files[0]);
  const auto failure{folder.write("failure.json", files[1])};
  accepts([&] {
    const auto done{batch::read_done(folder.path())};
    require(done.has_value(), "a file that is there is not found");
    static_cast<void>(batch::difference(folder.path(), *done));
  });
  accepts([&] { require(batch::read_failure(failure)->exit_code >= 0, "a failure without an exit code"); });
}

}  // namespace stereogrid::fuzz
