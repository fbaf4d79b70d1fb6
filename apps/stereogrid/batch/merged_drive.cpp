// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>
#include <system_error>

#include "batch/merge.hpp"
#include "batch/results.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

/// Adds run.json of a later part of a drive to that of the earlier ones.
void add_run(Json& all, const Json& part) {
  Json& frames(all["frames"]);
  const Json& more(part.at("frames"));
  frames["last"] = more.at("last");
  for (const char* key : {"done", "skipped"}) {
    frames[key] = frames.at(key).get<std::uint64_t>() + more.at(key).get<std::uint64_t>();
  }
  for (const Json& skipped : part.at("skipped")) all["skipped"].push_back(skipped);
  for (const auto& [flag, count] : part.at("status").items()) {
    all["status"][flag] = all["status"].value(flag, std::uint64_t{0}) + count.get<std::uint64_t>();
  }
  std::map<std::string, std::uint64_t> warnings;
  for (const Json* run : {&std::as_const(all), &part}) {
    for (const Json& warning : run->at("warnings"))
      warnings[warning.at("text")] += warning.at("frames").get<std::uint64_t>();
  }
  all["warnings"] = Json(Json::array());
  for (const auto& [text, count] : warnings) all["warnings"].push_back({{"text", text}, {"frames", count}});
  for (const char* key : {"mount", "level_rig"}) all[key] = part.at(key);
}

}  // namespace

DriveRun::DriveRun(const fs::path& runs, const Shard& first, std::size_t variants)
    : folder_{runs / (variants > 1 ? fmt::format("{}.v{}", first.drive, first.variant) : first.drive)} {
  io::create_folder(folder_);
  lines_.open(folder_ / "frames.jsonl", std::ios::binary | std::ios::trunc);
}

void DriveRun::add(const fs::path& result) {
  const fs::path file{result / "run.json"};
  io::read_json<Json>(io::printable_path(file), io::read_file(file, io::largest_bytes::json), "",
                      "Remove the shard's folder, then run it again.", [this](const Json& part) {
                        if (run_.is_null()) {
                          run_ = part;
                          run_.erase("warm_up");
                        } else {
                          add_run(run_, part);
                        }
                      });
  std::ifstream lines{result / "frames.jsonl", std::ios::binary};
  if (lines.peek() != std::ifstream::traits_type::eof()) lines_ << lines.rdbuf();
  for (const char* folder : {"grids", "predictions", "stages", "pictures"}) {
    if (!io::is_folder(result / folder)) continue;
    io::create_folder(folder_ / folder);
    for (const fs::path& entry : io::entries_of(result / folder)) {
      link_or_copy(entry, folder_ / folder / entry.filename());
    }
  }
}

void DriveRun::finish() {
  lines_.close();
  if (!lines_) throw DeviceError{io::printable_path(folder_) + ": cannot be written. Check the space there."};
  if (!run_.is_null()) io::write_file(folder_ / "run.json", io::json_text(run_, 1) + '\n');
}

void MergedTiming::add(const Json& timing, Sums& sums) {
  const double frames{timing.value("frames", 0.0)};
  ++sums.shards;
  sums.frames += frames;
  sums.seconds += timing.value("seconds", 0.0);
  if (!timing.contains("timing_ms")) return;
  for (const auto& [stage, times] : timing.at("timing_ms").items()) {
    sums.stage_ms[stage] += times.value("mean", 0.0) * frames;
  }
}

void MergedTiming::add(const Shard& shard, const Json& timing) {
  add(timing, variants_[shard.variant]);
  add(timing, hosts_[timing.value("host", "unknown")]);
}

Json MergedTiming::json_of(const Sums& sums) {
  Json stages(Json::object());
  for (const auto& [stage, ms] : sums.stage_ms) stages[stage] = sums.frames > 0 ? ms / sums.frames : 0;
  return {{"shards", sums.shards},
          {"frames", sums.frames},
          {"seconds", sums.seconds},
          {"frames_per_second", sums.seconds > 0 ? sums.frames / sums.seconds : 0},
          {"mean_ms", stages}};
}

Json MergedTiming::summary(const Plan& plan) const {
  Json variants(Json::array());
  for (const auto& [variant, sums] : variants_) {
    Json one{{"swept", plan.variants.at(variant).swept}};
    one.update(json_of(sums));
    variants.push_back(one);
  }
  Json hosts(Json::object());
  for (const auto& [host, sums] : hosts_) hosts[host] = json_of(sums);
  return {{"variants", variants}, {"hosts", hosts}};
}

}  // namespace stereogrid::app::batch
