// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// Paths of a shard in the plan's folder. Folders of three digits keep directories small.
struct ShardPlaces {
  ShardPlaces(const std::filesystem::path& plan, const std::string& digest);

  std::filesystem::path result;   ///< complete, with done.json, from the moment it exists
  std::filesystem::path work;     ///< locked by the runner; holds the checkpoint for the next one
  std::filesystem::path failed;   ///< file: the reason why the shard cannot be done
  std::filesystem::path skipped;  ///< file: the result lacks frames; done.json has their number
};

struct PartFile {
  std::string name;  ///< path within the result, with '/'
  std::uint64_t bytes{0};
  std::string sha256;
};

/// done.json: the files of a result.
struct Done {
  std::string digest;   ///< digest of the shard
  std::string content;  ///< digest of all files but timing.json, which depends on machine and time
  std::uint64_t frames{0};
  std::uint64_t skipped{0};
  double seconds{0};  ///< time of its runners, but for those that were killed
  double cost{0};
  std::vector<PartFile> files;
};

/// failed/….json: a shard that is not tried again.
struct Failure {
  std::string digest;
  std::uint64_t shard{0};
  int exit_code{0};
  std::string message;
  std::string host;
};

/// A figure of `evaluate`, and the number of its frames.
struct Figure {
  double value{0};
  double frames{0};
};
/// Figures by name: "occupancy.3-20.missed", "occupancy.motion.ghost_s", "obstacles.found".
using Figures = std::map<std::string, Figure>;

/// Returns the single numbers of what `stereogrid evaluate --json` writes, without null. `frames`: scored.
[[nodiscard]] Figures figures_of(const Json& evaluation, double frames);
[[nodiscard]] Json to_json(const Figures& figures);
[[nodiscard]] Figures figures_in(const Json& json);

/// Facts about a finished run beside its files.
struct RunFacts {
  double seconds{0};  ///< time of the shard's runners
  Json figures;       ///< figures.json
};

/// Makes a shard's result in the folder `result` from the folder `run`, which is not changed. Files are linked where
/// the file system can. Moves what depends on the machine and the time from run.json and frames.jsonl into timing.json.
/// Removes earlier contents of `result`. Returns frames and skipped. Throws DeviceError, InputError.
[[nodiscard]] Done make_result(const std::filesystem::path& run, const std::filesystem::path& result,
                               const RunFacts& facts);

/// Links a file under another name, or copies it where that is impossible. Throws DeviceError.
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

/// Digest of the names and checksums of all files but timing.json.
[[nodiscard]] std::string content_digest(const std::vector<PartFile>& files);

/// Writes all files of a folder to the disk, then done.json with their checksums. Throws DeviceError.
void write_done(const std::filesystem::path& folder, Done done);
/// Returns nothing where there is no done.json. Throws InputError.
[[nodiscard]] std::optional<Done> read_done(const std::filesystem::path& folder);
/// Compares every byte of a result with its done.json. Returns the first difference; "": none.
[[nodiscard]] std::string difference(const std::filesystem::path& folder, const Done& done);

/// Renames the folder to its final name, on disk when this returns. False: a finished result is there already, and
/// stays. Throws DeviceError.
[[nodiscard]] bool publish(const std::filesystem::path& from, const std::filesystem::path& result);

void write_failure(const std::filesystem::path& file, const Failure& failure);
[[nodiscard]] std::optional<Failure> read_failure(const std::filesystem::path& file);

/// Name of this machine.
[[nodiscard]] std::string host_name();

}  // namespace stereogrid::app::batch
