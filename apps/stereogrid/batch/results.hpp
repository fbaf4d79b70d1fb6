// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batch/plan.hpp"

namespace stereogrid::app::batch {

/// Where what of a shard lies in the plan's folder. Folders of three digits keep directories small.
struct ShardPlaces {
  ShardPlaces(const std::filesystem::path& plan, const std::string& digest);

  std::filesystem::path result;   ///< complete, with done.json, from the moment it is there
  std::filesystem::path work;     ///< while it is worked on, and what the next runner goes on from
  std::filesystem::path failed;   ///< file: it cannot be done, and why
  std::filesystem::path skipped;  ///< file: the result lacks frames; done.json has their number
};

struct PartFile {
  std::string name;  ///< with its folders, '/' between them
  std::uint64_t bytes{0};
  std::string sha256;
};

/// done.json: what a result consists of.
struct Done {
  std::string digest;   ///< the shard's
  std::string content;  ///< of the files that do not depend on when and where: all but timing.json
  std::uint64_t frames{0};
  std::uint64_t skipped{0};
  double seconds{0};  ///< that all its runners have taken
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

/// Sees to it that all files of a folder are on the disk, and returns them with their checksums, sorted by name. Throws
/// DeviceError.
[[nodiscard]] std::vector<PartFile> sealed_files(const std::filesystem::path& folder);

/// Of the names and checksums of all but timing.json.
[[nodiscard]] std::string content_digest(const std::vector<PartFile>& files);

/// Puts the checksums of the folder's files into done.json, and that on the disk. Throws DeviceError.
void write_done(const std::filesystem::path& folder, Done done);
/// None: there is none. Throws InputError.
[[nodiscard]] std::optional<Done> read_done(const std::filesystem::path& folder);
/// What differs between a result and its done.json; "": nothing. Looks at every byte.
[[nodiscard]] std::string difference(const std::filesystem::path& folder, const Done& done);

/// Renames the folder to its final name, on disk when this returns. False: a finished result is there already, and
/// stays. Throws DeviceError.
[[nodiscard]] bool publish(const std::filesystem::path& from, const std::filesystem::path& result);

void write_failure(const std::filesystem::path& file, const Failure& failure);
[[nodiscard]] std::optional<Failure> read_failure(const std::filesystem::path& file);

/// The machine's name.
[[nodiscard]] std::string host_name();

}  // namespace stereogrid::app::batch
