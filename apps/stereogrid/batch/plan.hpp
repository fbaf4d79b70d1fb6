// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batch/sha256.hpp"

namespace stereogrid::app::batch {

using Json = nlohmann::ordered_json;

/// A part of a drive with one of the plan's configurations; the unit of work of a runner.
struct Shard {
  std::uint64_t number{0};           ///< line in the manifest, from 0
  std::string digest{};              ///< digest of all that decides about the result; name of its folder
  std::string drive{};               ///< name, unique in a plan
  std::vector<std::string> input{};  ///< a folder, a bag, a scene, or two images
  std::size_t first{0};              ///< frames [first, end) of the input
  std::size_t end{0};
  std::size_t warm_up{0};      ///< frames before `first` that are processed, unwritten
  std::string input_digest{};  ///< digest of the whole input, not only of these frames
  std::size_t variant{0};      ///< index in Plan::variants
  double cost{0};              ///< estimate: frames, with warm-up, times pixels of one image

  friend bool operator==(const Shard&, const Shard&) = default;
};

/// One configuration of a sweep.
struct Variant {
  std::vector<std::string> swept;     ///< "key=value" of the swept parameters
  std::vector<std::string> settings;  ///< "key=value" of all parameters that differ from the preset
  Json config;                        ///< every parameter
};

/// plan.json: values common to all shards.
struct Plan {
  std::string version{};  ///< version of stereogrid; others refuse the plan
  std::string digest{};   ///< digest of manifest.jsonl and of the members below
  std::uint64_t shards{0};
  std::uint64_t drives{0};
  std::uint64_t frames{0};
  double cost{0};
  std::uint64_t memory_mb{0};   ///< estimate for a runner
  bool content_digests{false};  ///< input digests cover every byte
  Json run{};                   ///< options of `stereogrid run`
  std::vector<Variant> variants{};
  std::vector<std::string> left_out{};  ///< reasons why inputs were left out
};

[[nodiscard]] Json to_json(const Shard& shard);
/// Throws nlohmann::json's exceptions, and InputError without a file.
[[nodiscard]] Shard shard_of(const Json& line);

/// Digest of all that decides about the result of a shard: everything but its number, the drive's name and the cost.
[[nodiscard]] std::string digest_of(const Shard& shard, const Plan& plan);

/// Formats ascending numbers of shards as ranges, "3-7,12"; ", and more" replaces ranges beyond the first `most`.
[[nodiscard]] std::string text_of(const std::vector<std::uint64_t>& numbers, std::size_t most = SIZE_MAX);
/// Parses such a list; all numbers are below `end`. Throws ConfigError.
[[nodiscard]] std::vector<std::uint64_t> numbers_in(const std::string& text, std::uint64_t end);

/// Writes a plan's folder: manifest.jsonl and its index line by line, plan.json last.
class PlanWriter {
 public:
  /// Throws ConfigError where the folder holds a plan, DeviceError.
  explicit PlanWriter(std::filesystem::path folder);
  /// Fills in number and digest; `plan`: version, run and variants are set.
  void add(Shard shard, const Plan& plan);
  /// Fills in the counts and the digest, and writes plan.json. Throws DeviceError.
  void finish(Plan& plan);

 private:
  void check() const;

  std::filesystem::path folder_;
  std::ofstream manifest_;
  std::ofstream index_;
  Sha256 sha_;
  std::uint64_t shards_{0};
  std::uint64_t offset_{0};
  std::uint64_t frames_{0};
  double cost_{0};
};

/// Reads a plan's folder.
class PlanReader {
 public:
  /// Throws InputError: no plan, damaged, of another format.
  explicit PlanReader(std::filesystem::path folder);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] const Plan& plan() const { return plan_; }
  /// Reads one line of the manifest and checks its digest. Throws InputError.
  [[nodiscard]] Shard shard(std::uint64_t number) const;
  /// Visits all shards in their order, one at a time in memory, then checks the plan's digest. Throws InputError.
  void for_each(const std::function<void(const Shard&)>& take) const;

 private:
  [[noreturn]] void damaged(const char* file, const std::string& what) const;

  std::filesystem::path folder_;
  Plan plan_;
};

}  // namespace stereogrid::app::batch
