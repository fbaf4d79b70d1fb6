// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/push.hpp"

#include <string>
#include <system_error>

#include "batch/results.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app::batch {

namespace fs = std::filesystem;

void push_result(const fs::path& plan, const Shard& shard, Transfer& transfer) {
  if (!transfer.pushes()) return;
  const TransferOptions& how{transfer.options()};
  const ShardPlaces places{plan, shard.digest};
  const fs::path name{places.result.lexically_relative(plan / "results")};
  const fs::path note{plan / "pushed" / name};
  const std::string by_this_command{how.push + '\n'};
  std::error_code error;
  if (fs::exists(note, error) && io::read_file(note) == by_this_command) return;
  transfer.push({{"dir", fs::absolute(places.result).string()},
                 {"uri", uri_of(shard.input.front(), how.uris)},
                 {"result", name.generic_string()},
                 {"drive", shard.drive},
                 {"shard", std::to_string(shard.number)}});
  io::create_folder(note.parent_path());
  io::write_file(note, by_this_command);
}

}  // namespace stereogrid::app::batch
