// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/transfer.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "batch/child.hpp"
#include "batch/words.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double longest_pause_s{60};

std::string without_end(std::string path) {
  while (path.size() > 1 && path.ends_with('/')) path.pop_back();
  return path;
}

/// Prefix and URI.
std::pair<std::string, std::string> parts_of(const std::string& mapping) {
  const std::size_t sign{mapping.find('=')};
  if (!mapping.starts_with('/') || sign == std::string::npos || sign + 1 == mapping.size()) {
    throw ConfigError{fmt::format("--uri {}: give PREFIX=URI, where the prefix is an absolute path: /mnt/a=s3:a.",
                                  io::printable(mapping))};
  }
  return {without_end(mapping.substr(0, sign)), without_end(mapping.substr(sign + 1))};
}

void check_command(const char* option, const std::string& command, const std::map<std::string, std::string>& values,
                   const std::set<std::string>& needed) {
  if (command.empty()) return;
  static_cast<void>(filled_in(words_of(command), values));
  for (const std::string& name : needed) {
    if (command.find('{' + name + '}') != std::string::npos) continue;
    throw ConfigError{fmt::format("{} {}: {{{}}} is missing in it.", option, io::printable(command), name)};
  }
}

/// What a folder holds that was fetched: itself, or the one file that has its name.
std::string found_in(const fs::path& folder) {
  std::error_code error;
  const fs::path file{folder / folder.filename()};
  return fs::is_regular_file(file, error) ? file.string() : folder.string();
}

void read(const Json& json, TransferOptions& options) {
  options.uris = json.value("uris", options.uris);
  options.fetch = json.value("fetch", options.fetch);
  options.push = json.value("push", options.push);
  options.scratch = json.value("scratch", options.scratch);
  options.scratch_limit = json.value("scratch_limit", options.scratch_limit);
  if (json.contains("retries")) options.retries = static_cast<int>(io::whole_number(json, "retries", 0, 1000));
  if (json.contains("timeout_s"))
    options.timeout_s = static_cast<int>(io::whole_number(json, "timeout_s", 1, 10'000'000));
}

}  // namespace

void check(const TransferOptions& options) {
  for (const std::string& mapping : options.uris) static_cast<void>(parts_of(mapping));
  static_cast<void>(bytes_of(options.scratch_limit));
  check_command("--fetch", options.fetch, {{"uri", ""}, {"dir", ""}}, {"uri", "dir"});
  check_command("--push", options.push, {{"uri", ""}, {"dir", ""}, {"result", ""}, {"drive", ""}, {"shard", ""}},
                {"dir"});
  if (!options.fetch.empty() && options.uris.empty()) {
    throw ConfigError{"--fetch needs to know where the inputs are: give --uri PREFIX=URI, too."};
  }
}

Json to_json(const TransferOptions& options) {
  return {{"uris", options.uris},
          {"fetch", options.fetch},
          {"push", options.push},
          {"scratch", options.scratch},
          {"scratch_limit", options.scratch_limit},
          {"retries", options.retries},
          {"timeout_s", options.timeout_s}};
}

TransferOptions transfer_options_of(const PlanReader& plan) {
  TransferOptions options;
  io::read_json<Json>(io::printable_path(plan.folder() / "plan.json"), io::json_text(plan.transfer()), "'transfer' ",
                      "Make the plan anew: stereogrid batch plan.", [&](const Json& json) { read(json, options); });
  return options;
}

std::string uri_of(const std::string& path, const std::vector<std::string>& uris) {
  for (const std::string& mapping : uris) {
    const auto [prefix, uri]{parts_of(mapping)};
    if (path == prefix) return uri;
    if (path.starts_with(prefix == "/" ? prefix : prefix + '/')) {
      return uri + path.substr(prefix == "/" ? 0 : prefix.size());
    }
  }
  return "";
}

Transfer::Transfer(TransferOptions options, std::function<bool()> stopped)
    : options_{std::move(options)},
      stopped_{std::move(stopped)},
      shared_{options_.scratch.empty() ? fs::temp_directory_path() : fs::absolute(options_.scratch)},
      limit_{bytes_of(options_.scratch_limit)} {}

bool Transfer::fetches(const std::string& path) const {
  return !options_.fetch.empty() && !uri_of(path, options_.uris).empty();
}

Transfer::Places Transfer::fetch(const std::vector<std::string>& paths,
                                 const std::function<std::string(const Places&)>& wrong) {
  std::vector<std::string> far;
  for (const std::string& path : paths) {
    if (fetches(path)) far.push_back(path);
  }
  const bool all_there{places_.size() == far.size() &&
                       std::ranges::all_of(far, [this](const std::string& path) { return places_.contains(path); })};
  if (far.empty() || (all_there && wrong(places_).empty())) return far.empty() ? Places{} : places_;
  try {
    try_often("the input was not fetched", [&] {
      const std::string why{fetch_once(far)};
      return why.empty() ? wrong(places_) : why;
    });
  } catch (const DeviceError&) {
    places_.clear();
    scratch_.reset();
    throw;
  }
  return places_;
}

std::string Transfer::fetch_once(const std::vector<std::string>& paths) {
  places_.clear();
  scratch_.reset();
  scratch_.emplace(shared_);
  Places places;
  for (std::size_t i{0}; i < paths.size(); ++i) {
    const fs::path name{fs::path{paths[i]}.filename()};
    const fs::path folder{scratch_->path() / std::to_string(i) / (name.empty() ? fs::path{"input"} : name)};
    io::create_folder(folder);
    const std::string why{
        run(options_.fetch, {{"uri", uri_of(paths[i], options_.uris)}, {"dir", folder.string()}}, true)};
    if (!why.empty()) return why;
    places[paths[i]] = found_in(folder);
  }
  places_ = std::move(places);
  return "";
}

void Transfer::push(const std::map<std::string, std::string>& values) {
  try_often("the result was not pushed", [&] { return run(options_.push, values, false); });
}

std::string Transfer::run(const std::string& command, const std::map<std::string, std::string>& values,
                          bool to_scratch) {
  const std::string too_much{
      fmt::format("{} holds more than {} of fetched inputs. Allow more with --scratch-limit, or let fewer runners work "
                  "there",
                  io::printable_path(shared_), options_.scratch_limit)};
  full_ = false;
  auto next{Clock::now()};
  const std::string why{run_child(filled_in(words_of(command), values), options_.timeout_s, [&]() -> std::string {
    if (stopped_()) return "stopped";
    const auto begin{Clock::now()};
    if (!to_scratch || begin < next) return "";
    full_ = scratch_bytes(shared_) > limit_;
    // looking takes long where there are many files
    next = Clock::now() + std::max<Clock::duration>(std::chrono::milliseconds{500}, 10 * (Clock::now() - begin));
    return full_ ? too_much : "";
  })};
  if (!to_scratch || full_) return why;
  full_ = scratch_bytes(shared_) > limit_;
  return full_ ? too_much : why;
}

void Transfer::try_often(const std::string& what, const std::function<std::string()>& once) {
  for (int tries{0};; ++tries) {
    const std::string why{once()};
    if (why.empty()) return;
    if (stopped_()) throw DeviceError{"stopped"};
    if (full_ || tries >= options_.retries) {
      throw DeviceError{fmt::format("{}: {} ({} tries).", what, why, tries + 1)};
    }
    spdlog::warn("{}: {}; trying again", what, why);
    wait_after(tries);
  }
}

/// Longer each time, and not all runners at once.
void Transfer::wait_after(int tries) {
  std::random_device chance;
  const double share{0.5 + static_cast<double>(chance() % 1000) / 1000};
  const double seconds{share * std::min(longest_pause_s, static_cast<double>(1LL << std::min(tries, 10)))};
  const auto end{Clock::now() + std::chrono::duration<double>(seconds)};
  while (Clock::now() < end && !stopped_()) std::this_thread::sleep_for(std::chrono::milliseconds{50});
}

}  // namespace stereogrid::app::batch
