// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "batch/plan.hpp"
#include "batch/scratch.hpp"
#include "cli_fwd.hpp"

namespace stereogrid::app::batch {

/// How inputs come from far away, and results go there: kept in plan.json, or told to `batch run`.
struct TransferOptions {
  std::vector<std::string> uris{};  ///< "PREFIX=URI": where inputs below a path are
  std::string fetch{};              ///< "": inputs are read where they are
  std::string push{};               ///< "": results stay where they are
  std::string scratch{};            ///< "": the system's folder for temporary files
  std::string scratch_limit{"50G"};
  int retries{3};
  int timeout_s{3600};  ///< of one try
};

void add_transfer_options(CLI::App& command, TransferOptions& options);
/// Throws ConfigError.
void check(const TransferOptions& options);

[[nodiscard]] Json to_json(const TransferOptions& options);
/// What is not there is as by default. Throws InputError.
[[nodiscard]] TransferOptions transfer_options_of(const PlanReader& plan);
/// The plan's, but what was given on the command line.
[[nodiscard]] TransferOptions with_given(TransferOptions planned, const CLI::App& command,
                                         const TransferOptions& given);

/// "": none of the prefixes is of this path.
[[nodiscard]] std::string uri_of(const std::string& path, const std::vector<std::string>& uris);

/// Fetches inputs into a scratch folder and pushes results, again and again where that fails. What was fetched is kept
/// until something else is, and removed when this ends.
class Transfer {
 public:
  /// `stopped`: asked between and during tries.
  Transfer(TransferOptions options, std::function<bool()> stopped);

  [[nodiscard]] bool fetches(const std::string& path) const;
  [[nodiscard]] bool pushes() const { return !options_.push.empty(); }
  [[nodiscard]] const TransferOptions& options() const { return options_; }

  /// Fetches those of the paths that have a URI. Returns where each lies now. `wrong`: what is wrong with what came;
  /// "": nothing. Throws DeviceError: it did not come in as many tries as there are, or there is no space.
  using Places = std::map<std::string, std::string>;
  Places fetch(const std::vector<std::string>& paths, const std::function<std::string(const Places&)>& wrong);

  /// `values`: what is filled in. Throws DeviceError.
  void push(const std::map<std::string, std::string>& values);

 private:
  void try_often(const std::string& what, const std::function<std::string()>& once);
  void wait_after(int tries);
  std::string fetch_once(const std::vector<std::string>& paths);
  std::string run(const std::string& command, const std::map<std::string, std::string>& values, bool to_scratch);

  TransferOptions options_;
  std::function<bool()> stopped_;
  std::filesystem::path shared_;
  std::uint64_t limit_;
  std::optional<ScratchFolder> scratch_;
  Places places_;
  bool full_{false};
};

}  // namespace stereogrid::app::batch
