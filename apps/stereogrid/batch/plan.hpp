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

/// A part of a drive with one of the plan's configurations: what is worked on, repeated and handed out as a whole.
struct Shard {
  std::uint64_t number{0};           ///< its line in the manifest, from 0
  std::string digest{};              ///< of all that decides about the result; names its folder
  std::string drive{};               ///< a name, once in a plan
  std::vector<std::string> input{};  ///< a folder, a bag, a scene, or two images
  std::size_t first{0};              ///< frames [first, end) of it
  std::size_t end{0};
  std::size_t warm_up{0};      ///< so many frames before them go through the pipeline, too
  std::string after{};         ///< digest of the shard that it goes on from; "": none
  std::string input_digest{};  ///< of the whole input, not only of these frames
  std::size_t variant{0};      ///< of Plan::variants
  double cost{0};              ///< estimate: frames, with warm-up, times pixels of one image

  friend bool operator==(const Shard&, const Shard&) = default;
};

/// One configuration of a sweep.
struct Variant {
  std::vector<std::string> swept;     ///< "key=value" that tell it from the others
  std::vector<std::string> settings;  ///< "key=value", all that differ from the preset
  Json config;                        ///< every parameter
};

/// plan.json: what all shards have in common.
struct Plan {
  std::string version{};  ///< of stereogrid, which alone can work on it
  std::string digest{};   ///< of manifest.jsonl and of all that follows
  std::uint64_t shards{0};
  std::uint64_t drives{0};
  std::uint64_t frames{0};
  double cost{0};
  std::uint64_t memory_mb{0};   ///< that a runner needs, estimated
  bool hand_on{false};          ///< shards go on from what their predecessors remembered
  bool content_digests{false};  ///< of inputs: of all bytes
  Json run{};                   ///< options of `stereogrid run`
  std::vector<Variant> variants{};
  std::vector<std::string> left_out{};  ///< inputs that could not be used, with why
};

[[nodiscard]] Json to_json(const Shard& shard);
/// Throws what nlohmann::json throws, and InputError without file.
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
  /// Fills in number, after and digest; `plan`: version, run and variants are set. `follows`: goes on from the shard
  /// added last.
  void add(Shard shard, const Plan& plan, bool follows);
  /// Fills in what it has counted, and the digest. Throws DeviceError.
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
  std::string last_digest_;
};

/// A plan's folder.
class PlanReader {
 public:
  /// Throws InputError: no plan, damaged, of another format.
  explicit PlanReader(std::filesystem::path folder);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] const Plan& plan() const { return plan_; }
  /// By the index, and checked against its own digest. Throws InputError.
  [[nodiscard]] Shard shard(std::uint64_t number) const;
  /// All, in their order, one at a time in memory; at the end the digest of the plan is checked. Throws InputError.
  void for_each(const std::function<void(const Shard&)>& take) const;

 private:
  [[noreturn]] void damaged(const char* file, const std::string& what) const;

  std::filesystem::path folder_;
  Plan plan_;
};

}  // namespace stereogrid::app::batch
