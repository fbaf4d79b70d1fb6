// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/level_mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "run_folder/description_json.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double quantile(const std::vector<double>& sorted, double share) {
  const double place{share * static_cast<double>(sorted.size() - 1)};
  const auto below{static_cast<std::size_t>(place)};
  const std::size_t above{std::min(below + 1, sorted.size() - 1)};
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

Percentiles percentiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const double sum{std::accumulate(values.begin(), values.end(), 0.0)};
  return {quantile(values, 0.5), quantile(values, 0.9), quantile(values, 0.99),
          sum / static_cast<double>(values.size())};
}

/// The sentences of all frames, each once, with the number of frames that said it.
Json warnings_json(const std::vector<FrameSummary>& frames) {
  std::map<std::string, int> counts;
  for (const FrameSummary& frame : frames) {
    for (const Warning& warning : frame.warnings) ++counts[warning.text];
  }
  Json list(Json::array());
  for (const auto& [text, count] : counts) list.push_back({{"text", text}, {"frames", count}});
  return list;
}

/// Name of a run's file in a folder; "": none.
std::string part_of_a_run(const fs::path& folder) {
  for (const char* const file : {"run.json", "frames.jsonl"}) {
    if (is_there(folder / file)) return file;
  }
  return has_entries(folder / "grids") ? "grids" : "";
}

/// Values of a run.json under the keys of `settings`, without those within lists or objects.
Json settings_in(const Json& before, const Json& settings) {
  Json found(Json::object());
  for (const auto& [key, value] : settings.items()) {
    if (before.contains(key)) found[key] = before.at(key);
  }
  return found.flatten();
}

/// True if both have the same parameters, with whatever values.
bool has_same_parameters(const Json& before, const Json& now) {
  for (const auto& [group, parameters] : now.items()) {
    const Json there(before.value(group, Json(Json::object())));
    if (there.size() != parameters.size()) return false;
    for (const auto& [name, unused] : parameters.items()) {
      if (!there.contains(name)) return false;
    }
  }
  return true;
}

/// Throws ConfigError naming the settings that differ.
void check_same_settings(const fs::path& file, const Json& before, const RunDescription& run) {
  const Json settings(settings_json(run));
  const Json now(settings.flatten());
  const Json then(settings_in(before, settings));
  Json all(then);
  all.update(now);
  std::string differing;
  for (const auto& [key, unused] : all.items()) {
    const Json old(then.value(key, Json{}));
    const Json value(now.value(key, Json{}));
    if (old != value)
      differing += fmt::format("\n  {}: was {}, is {}", key.substr(1), json_text(old), json_text(value));
  }
  const Json first_before(before.value(Json::json_pointer{"/frames/first"}, Json{}));
  if (first_before != Json(run.frames.first)) {
    differing += fmt::format("\n  first frame: was {}, is {}", json_text(first_before), run.frames.first);
  }
  if (differing.empty()) return;
  throw ConfigError{fmt::format("{} was begun {}:{}", printable_path(file),
                                has_same_parameters(before.value("config", Json(Json::object())), settings.at("config"))
                                    ? "with other settings; a run continues only with its own"
                                    : "by another version, which has other parameters. Continue with that "
                                      "version, or give another --out",
                                differing)};
}

std::vector<SkippedFrame> skipped_in(const Json& run) {
  std::vector<SkippedFrame> skipped;
  for (const Json& frame : run.value("skipped", Json(Json::array()))) {
    skipped.push_back({static_cast<std::size_t>(whole_number(frame, "index", 0, largest_index)),
                       frame.value("name", ""), frame.value("reason", "")});
  }
  return skipped;
}

}  // namespace

RunRecord::RunRecord(fs::path folder, RunDescription run)
    : folder_{std::move(folder)}, run_{std::move(run)}, mounted_rig_{run_.rig} {}

void RunRecord::begin() {
  if (const std::string part{part_of_a_run(folder_)}; !part.empty()) {
    throw ConfigError{fmt::format("{} already holds a run ({}). Continue it with --resume, or give another folder.",
                                  printable_path(folder_), part)};
  }
  create_folder(folder_);
  save(false);
}

void RunRecord::resume() {
  const std::string part{part_of_a_run(folder_)};
  if (part.empty()) return begin();
  const fs::path file{folder_ / "run.json"};
  if (part != "run.json") {
    throw InputError{printable_path(file), fmt::format("is missing, but there are results of a run ({}).", part),
                     "Without it their settings are unknown. Put it back, or start the run anew in another folder."};
  }
  read_json<Json>(printable_path(file), read_text(file, largest_bytes::json), "",
                  "Start the run anew in another folder.", [&](const Json& before) {
                    if (!before.is_object()) throw InputError{"it is not an object"};
                    check_same_settings(file, before, run_);
                    skipped_ = skipped_in(before);
                  });
  finished_ = take_finished_frames(folder_ / "frames.jsonl");
  check_range();
  check_grids();
  save(false);
}

void RunRecord::check_range() const {
  if (finished_.empty()) return;
  const std::size_t first{finished_.front().index};
  const std::size_t last{finished_.back().index};
  if (first >= run_.frames.first && last < run_.frames.end) return;
  throw ConfigError{
      fmt::format("{} holds frames {} to {}, but this run is of {} to {}. Give --frames that they lie in.",
                  printable_path(folder_ / "frames.jsonl"), first, last, run_.frames.first, run_.frames.end - 1)};
}

void RunRecord::check_grids() const {
  for (const FrameSummary& frame : finished_) {
    const fs::path grids{folder_ / "grids" / (frame.name + ".npz")};
    if (is_there(grids)) continue;
    throw InputError{printable_path(grids), "is missing, but frames.jsonl says that its frame is finished.",
                     "Put it back, or remove the lines from that frame on in frames.jsonl: they are processed again."};
  }
}

void RunRecord::add_skipped(SkippedFrame frame) {
  const auto place{std::ranges::upper_bound(skipped_, frame.index, {}, &SkippedFrame::index)};
  skipped_.insert(place, std::move(frame));
}

void RunRecord::continue_from(std::size_t index) {
  const std::size_t next{std::max(index, finished_.empty() ? 0 : finished_.back().index + 1)};
  std::erase_if(skipped_, [next](const SkippedFrame& frame) { return frame.index >= next; });
}

bool RunRecord::is_skipped(std::size_t index) const {
  const auto place{std::ranges::lower_bound(skipped_, index, {}, &SkippedFrame::index)};
  return place != skipped_.end() && place->index == index;
}

std::vector<std::size_t> RunRecord::unaccounted() const {
  std::vector<std::size_t> missing;
  std::set<std::size_t> known;
  for (const SkippedFrame& frame : skipped_) known.insert(frame.index);
  std::size_t next{run_.frames.first};
  for (const FrameSummary& frame : finished_) {
    for (; next < frame.index; ++next) {
      if (is_written(next) && !known.contains(next)) missing.push_back(next);
    }
    next = frame.index + 1;
  }
  return missing;
}

Percentiles RunRecord::timing(double StageTimes::*stage) const {
  std::vector<double> values;
  for (const FrameSummary& frame : finished_) values.push_back(frame.timing_ms.*stage);
  return percentiles(std::move(values));
}

std::size_t RunRecord::frames_with(FrameStatus flag) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(finished_, [&](const FrameSummary& frame) { return has_any(frame.status, {flag}); }));
}

void RunRecord::save(bool complete) const {
  Json run(settings_json(run_));
  run["mount"] = {{"camera_height_m", mounted_rig_.camera_height_m},
                  {"camera_pitch_rad", mounted_rig_.camera_pitch_rad},
                  {"camera_roll_rad", mounted_rig_.camera_roll_rad}};
  run["level_rig"] = rig_json(LevelMapping{mounted_rig_}.level_rig());
  run["simd_target"] = run_.simd_target;
  run["threads"] = run_.threads;
  run["frames"] = {{"first", run_.frames.first},
                   {"last", run_.frames.end - 1},
                   {"done", finished_.size()},
                   {"skipped", skipped_.size()},
                   {"complete", complete}};
  Json& timing{run["timing_ms"]};
  for (const StageField& stage : stage_fields) {
    const Percentiles p{this->timing(stage.milliseconds)};
    timing[std::string{stage.name}] = {{"p50", p.p50}, {"p90", p.p90}, {"p99", p.p99}, {"mean", p.mean}};
  }
  Json& skipped{run["skipped"] = Json::array()};
  for (const SkippedFrame& frame : skipped_) {
    skipped.push_back({{"index", frame.index}, {"name", frame.name}, {"reason", frame.reason}});
  }
  Json& status{run["status"] = Json::object()};
  constexpr auto names{names_of(FrameStatus{})};
  for (std::size_t i{0}; i < names.size(); ++i) {
    const std::size_t frames{frames_with(static_cast<FrameStatus>(i))};
    if (frames > 0) status[std::string{names[i]}] = frames;
  }
  run["warnings"] = warnings_json(finished_);
  write_file(folder_ / "run.json", json_text(run, 2) + "\n");
}

}  // namespace stereogrid::io
