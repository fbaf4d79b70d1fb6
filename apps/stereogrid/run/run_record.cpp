// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/run_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <system_error>

#include "run/stages.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {
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
    for (const std::string& warning : frame.warnings) ++counts[warning];
  }
  Json list(Json::array());
  for (const auto& [text, count] : counts) list.push_back({{"text", text}, {"frames", count}});
  return list;
}

bool holds_files(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) && !fs::is_empty(folder, error);
}

/// What of a run lies in a folder; "": nothing.
std::string part_of_a_run(const fs::path& folder) {
  std::error_code error;
  for (const char* const file : {"run.json", "frames.jsonl"}) {
    if (fs::exists(folder / file, error)) return file;
  }
  return holds_files(folder / "grids") ? "grids" : "";
}

}  // namespace

RunRecord::RunRecord(fs::path folder, FrameRange range, Json settings, Json machine)
    : folder_{std::move(folder)}, range_{range}, settings_(std::move(settings)), machine_(std::move(machine)) {}

void RunRecord::begin() {
  if (const std::string part{part_of_a_run(folder_)}; !part.empty()) {
    throw ConfigError{fmt::format("{} already holds a run ({}). Go on with it: --resume; or give another folder.",
                                  io::printable_path(folder_), part)};
  }
  io::create_folder(folder_);
  save(false);
}

void RunRecord::resume() {
  const std::string part{part_of_a_run(folder_)};
  if (part.empty()) return begin();
  const fs::path file{folder_ / "run.json"};
  if (part != "run.json") {
    throw InputError{
        io::printable_path(file), fmt::format("is missing, but there are results of a run ({}).", part),
        "Without it nobody knows how they were made. Put it back, or start the run anew in another folder."};
  }
  io::read_json<Json>(io::printable_path(file), io::read_text(file, io::largest_bytes::json), "",
                      "Start the run anew in another folder.", [this](const Json& before) {
                        if (!before.is_object()) throw InputError{"it is no object"};
                        check_same_settings(before);
                        take_skipped(before);
                      });
  finished_ = read_frame_lines(folder_ / "frames.jsonl");
  check_range();
  // those behind the last finished one are tried again
  const std::size_t next{finished_.frames.empty() ? 0 : finished_.frames.back().index + 1};
  std::erase_if(skipped_, [next](const SkippedFrame& frame) { return frame.index >= next; });
  save(false);
}

void RunRecord::check_same_settings(const Json& before) const {
  const Json now(settings_.flatten());
  const Json then(before.flatten());
  std::string differing;
  for (const auto& [key, value] : now.items()) {
    const Json old(then.contains(key) ? then.at(key) : Json{});
    if (old != value)
      differing += fmt::format("\n  {}: was {}, is {}", key.substr(1), io::json_text(old), io::json_text(value));
  }
  const Json first_before(before.value(Json::json_pointer{"/frames/first"}, Json{}));
  if (first_before != Json(range_.first)) {
    differing += fmt::format("\n  first frame: was {}, is {}", io::json_text(first_before), range_.first);
  }
  if (differing.empty()) return;
  throw ConfigError{fmt::format("{} was begun with other settings; a run goes on only with its own:{}",
                                io::printable_path(folder_ / "run.json"), differing)};
}

void RunRecord::check_range() const {
  if (finished_.frames.empty()) return;
  const std::size_t first{finished_.frames.front().index};
  const std::size_t last{finished_.frames.back().index};
  if (first >= range_.first && last < range_.end) return;
  throw ConfigError{
      fmt::format("{} holds frames {} to {}, but this run is of {} to {}. Give --frames that they lie in.",
                  io::printable_path(folder_ / "frames.jsonl"), first, last, range_.first, range_.end - 1)};
}

void RunRecord::take_skipped(const Json& before) {
  for (const Json& frame : before.value("skipped", Json(Json::array()))) {
    SkippedFrame skipped{static_cast<std::size_t>(io::whole_number(frame, "index", 0, largest_index)),
                         frame.value("name", ""), frame.value("reason", "")};
    skipped_.push_back(std::move(skipped));
  }
}

void RunRecord::add_skipped(SkippedFrame frame) {
  const auto place{std::ranges::upper_bound(skipped_, frame.index, {}, &SkippedFrame::index)};
  skipped_.insert(place, std::move(frame));
}

std::vector<std::size_t> RunRecord::unaccounted() const {
  std::vector<std::size_t> missing;
  std::set<std::size_t> known;
  for (const SkippedFrame& frame : skipped_) known.insert(frame.index);
  std::size_t next{range_.first};
  for (const FrameSummary& frame : finished_.frames) {
    for (; next < frame.index; ++next) {
      if (!known.contains(next)) missing.push_back(next);
    }
    next = frame.index + 1;
  }
  return missing;
}

Percentiles RunRecord::timing(double StageTimes::*stage) const {
  std::vector<double> values;
  for (const FrameSummary& frame : finished_.frames) values.push_back(frame.timing_ms.*stage);
  return percentiles(std::move(values));
}

std::size_t RunRecord::frames_with(FrameStatus flag) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      finished_.frames, [&](const FrameSummary& frame) { return std::ranges::count(frame.status, flag) > 0; }));
}

Json RunRecord::status_json() const {
  constexpr auto names{names_of(FrameStatus{})};
  Json counts(Json::object());
  for (std::size_t i{0}; i < names.size(); ++i) {
    const std::size_t frames{frames_with(static_cast<FrameStatus>(i))};
    if (frames > 0) counts[std::string{names[i]}] = frames;
  }
  return counts;
}

Json RunRecord::frames_json(bool complete) const {
  return {{"first", range_.first},
          {"last", range_.end - 1},
          {"done", finished_.frames.size()},
          {"skipped", skipped_.size()},
          {"complete", complete}};
}

void RunRecord::save(bool complete) const {
  Json run(settings_);
  run.update(machine_);
  run["frames"] = frames_json(complete);
  Json& timing{run["timing_ms"]};
  for (const StageField& stage : stage_fields) {
    const Percentiles p{this->timing(stage.milliseconds)};
    timing[std::string{stage.name}] = {{"p50", p.p50}, {"p90", p.p90}, {"p99", p.p99}, {"mean", p.mean}};
  }
  Json& skipped{run["skipped"] = Json::array()};
  for (const SkippedFrame& frame : skipped_) {
    skipped.push_back({{"index", frame.index}, {"name", frame.name}, {"reason", frame.reason}});
  }
  run["status"] = status_json();
  run["warnings"] = warnings_json(finished_.frames);
  io::write_file(folder_ / "run.json", io::json_text(run, 2) + "\n");
}

}  // namespace stereogrid::app
