// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/merge.hpp"

#include <fmt/format.h>

#include <optional>
#include <system_error>

#include "batch/status.hpp"
#include "cli/progress.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/run_folder/description.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_named{20};

/// A file of lines.
class Lines {
 public:
  explicit Lines(const fs::path& path) : path_{path}, file_{path, std::ios::binary | std::ios::trunc} {}
  void add(const Json& line) {
    file_ << io::json_text(line) << '\n';
    check();
  }
  void close() {
    file_.close();
    check();
  }

 private:
  void check() const {
    if (!file_) throw DeviceError{io::printable_path(path_) + ": cannot be written. Check the space there."};
  }
  fs::path path_;
  std::ofstream file_;
};

/// Counts of a drive with one configuration, or of all drives with it.
struct Counts {
  std::uint64_t shards{0};
  std::uint64_t missing{0};
  std::uint64_t failed{0};
  std::uint64_t planned{0};  ///< frames that the shards write where none is skipped
  std::uint64_t frames{0};
  std::uint64_t skipped{0};

  void add(const Counts& other) {
    shards += other.shards;
    missing += other.missing;
    failed += other.failed;
    planned += other.planned;
    frames += other.frames;
    skipped += other.skipped;
  }
};

Json to_json(const Counts& counts) {
  return {{"shards", counts.shards},   {"missing", counts.missing}, {"failed", counts.failed},
          {"planned", counts.planned}, {"frames", counts.frames},   {"skipped", counts.skipped}};
}

struct OfVariant {
  std::uint64_t drives{0};
  Counts counts;
  FiguresOverDrives figures;
};

Json json_of_file(const fs::path& file) {
  Json read;
  io::read_json<Json>(io::printable_path(file), io::read_file(file), "",
                      "Remove the shard's folder, then run it again.", [&](const Json& json) { read = json; });
  return read;
}

class Merger {
 public:
  Merger(const PlanReader& plan, const MergeOptions& options)
      : plan_{plan},
        options_{options},
        states_{plan.folder()},
        variants_(plan.plan().variants.size()),
        parts_{options.out / "parts.jsonl"},
        drives_{options.out / "drives.jsonl"} {}

  MergedFrames run() {
    Progress progress{"shards", plan_.plan().shards};
    plan_.for_each([&](const Shard& shard) {
      if (!same_drive(shard)) end_drive();
      if (!current_) begin_drive(shard);
      take(shard);
      progress.update(shard.number + 1);
    });
    end_drive();
    parts_.close();
    drives_.close();
    const Json all(summary());
    io::write_file(options_.out / "summary.json", io::json_text(all, 1) + '\n');
    io::write_file(options_.out / "summary.html", summary_page(all));
    io::write_file(options_.out / "timing.json", io::json_text(timing_.summary(plan_.plan()), 1) + '\n');
    return {all.at("planned"), all.at("frames")};
  }

 private:
  bool same_drive(const Shard& shard) const {
    return !current_ || (current_->drive == shard.drive && current_->variant == shard.variant);
  }

  void begin_drive(const Shard& shard) {
    current_ = shard;
    counts_ = {};
    figures_.clear();
    if (options_.runs) run_.emplace(options_.out / "runs", shard, plan_.plan().variants.size());
  }

  void end_drive() {
    if (!current_) return;
    if (run_) run_->finish();
    run_.reset();
    Json line{{"drive", current_->drive}, {"variant", current_->variant}};
    line.update(to_json(counts_));
    Json values(Json::object());
    for (const auto& [name, figure] : figures_) values[name] = figure.value;
    line["figures"] = values;
    drives_.add(line);
    OfVariant& all{variants_.at(current_->variant)};
    ++all.drives;
    all.counts.add(counts_);
    all.figures.add(figures_);
    current_.reset();
  }

  void take(const Shard& shard) {
    ++counts_.shards;
    counts_.planned +=
        io::multiples_between(shard.first, shard.end - 1, plan_.plan().run.value("every", std::size_t{1}));
    const ShardPlaces places{plan_.folder(), shard.digest};
    const ShardState state{states_.of(shard.digest)};
    Json part{{"shard", shard.number}, {"digest", shard.digest}, {"drive", shard.drive}, {"variant", shard.variant}};
    if (state == ShardState::done) {
      take_result(shard, places.result, part);
    } else {
      const auto failure{read_failure(places.failed)};
      ++(failure ? counts_.failed : counts_.missing);
      part["state"] = failure ? "failed" : "missing";
      if (failure) part["why"] = failure->message;
    }
    parts_.add(part);
  }

  void take_result(const Shard& shard, const fs::path& folder, Json& part) {
    const auto done{read_done(folder)};
    const std::string wrong{!done                          ? "done.json is missing"
                            : done->digest != shard.digest ? "it is the result of another shard"
                                                           : difference(folder, *done)};
    if (!wrong.empty()) {
      throw InputError{
          fmt::format("shard {}: its result is damaged: {} ({}).", shard.number, wrong, io::printable_path(folder)),
          "Nothing was merged.",
          fmt::format("Remove that folder, then: stereogrid batch run PLAN --shard {}", shard.number)};
    }
    counts_.frames += done->frames;
    counts_.skipped += done->skipped;
    part["state"] = "done";
    part["frames"] = done->frames;
    part["skipped"] = done->skipped;
    part["content"] = done->content;
    for (const PartFile& file : done->files) {
      if (file.name == "figures.json") take_figures(folder / file.name, part);
      if (file.name == "timing.json") timing_.add(shard, json_of_file(folder / file.name));
    }
    if (run_) run_->add(folder);
  }

  void take_figures(const fs::path& file, Json& part) {
    const Json json(json_of_file(file));
    if (json.contains("not scored")) {
      part["not_scored"] = json.at("not scored");
    } else {
      add_part(figures_, figures_in(json));
    }
  }

  Json summary() const {
    Json variants(Json::array());
    Counts all;
    for (std::size_t i{0}; i < variants_.size(); ++i) {
      const OfVariant& of{variants_[i]};
      all.add(of.counts);
      Json variant{{"swept", plan_.plan().variants[i].swept}, {"drives", of.drives}};
      variant.update(to_json(of.counts));
      Json figures(Json::object());
      for (const auto& [name, figure] : of.figures.means()) {
        Json one{{"value", figure.value}, {"low", nullptr}, {"high", nullptr}, {"drives", figure.drives}};
        if (figure.low <= figure.high) {
          one["low"] = figure.low;
          one["high"] = figure.high;
        }
        figures[name] = one;
      }
      variant["figures"] = figures;
      variants.push_back(variant);
    }
    Json json{{"plan", plan_.plan().digest}, {"version", plan_.plan().version}, {"drives", plan_.plan().drives}};
    json.update(to_json(all));
    json["left_out"] = plan_.plan().left_out;
    json["variants"] = variants;
    return json;
  }

  const PlanReader& plan_;
  const MergeOptions& options_;
  ShardStates states_;
  std::vector<OfVariant> variants_;
  Lines parts_;
  Lines drives_;
  MergedTiming timing_;
  std::optional<Shard> current_;
  Counts counts_;
  Figures figures_;
  std::optional<DriveRun> run_;
};

/// Throws InputError with the numbers of the missing shards.
void check_complete(const PlanReader& plan) {
  const ShardStates states{plan.folder()};
  std::vector<std::uint64_t> missing;
  plan.for_each([&](const Shard& shard) {
    if (states.of(shard.digest) != ShardState::done) missing.push_back(shard.number);
  });
  if (missing.empty()) return;
  throw InputError{io::printable_path(plan.folder()),
                   fmt::format("{} of {} shards have no result: {}.", missing.size(), plan.plan().shards,
                               text_of(missing, most_named)),
                   "Run them, or merge the others with --allow-missing; stereogrid batch status lists the reasons."};
}

}  // namespace

MergedFrames merge(const PlanReader& plan, const MergeOptions& options) {
  std::error_code error;
  if (io::has_entries(options.out)) {
    throw ConfigError{fmt::format("{} is not empty. Give another folder.", io::printable_path(options.out))};
  }
  if (!options.allow_missing) check_complete(plan);
  fs::path out{fs::absolute(options.out).lexically_normal()};
  if (!out.has_filename()) out = out.parent_path();
  // a temporary name until the folder is complete
  MergeOptions inside{options};
  inside.out = out;
  inside.out += ".partial";
  fs::remove_all(inside.out, error);
  io::create_folder(inside.out);
  const MergedFrames frames{Merger{plan, inside}.run()};
  fs::remove(out, error);
  if (!publish(inside.out, out)) {
    throw DeviceError{
        fmt::format("{}: another process has created it meanwhile. Give another folder.", io::printable_path(out))};
  }
  return frames;
}

}  // namespace stereogrid::app::batch
