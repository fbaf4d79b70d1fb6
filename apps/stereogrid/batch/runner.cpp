// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/runner.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <new>
#include <system_error>

#include "batch/results.hpp"
#include "cli/commands.hpp"
#include "cli/console.hpp"
#include "cli/interrupt.hpp"
#include "evaluate/evaluate.hpp"
#include "locks/folder_lock.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/text.hpp"
#include "thread_failure.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Replaces the folder that a shard is processed in by "work": merged texts do not depend on it.
std::string without_place(std::string text, const fs::path& work) {
  const std::string place{work.string()};
  for (std::size_t at{text.find(place)}; at != std::string::npos; at = text.find(place)) {
    text.replace(at, place.size(), "work");
  }
  return text;
}

/// Number of lines of a run's frames.jsonl.
std::uint64_t finished_frames(const fs::path& run) {
  std::ifstream file{run / "frames.jsonl", std::ios::binary};
  std::uint64_t lines{0};
  for (std::string line; std::getline(file, line);) lines += file.eof() ? 0 : 1;
  return lines;
}

/// figures.json of a finished run: scores, or why there are none; null: there is no truth.
Json scores_of(const RunOptions& run, const fs::path& work) {
  try {
    if (!can_be_scored(open_input(run.input))) return {};
    EvaluateOptions options;
    options.run = run.folder;
    return to_json(
        figures_of(json_of(evaluate_with_progress(options)), static_cast<double>(finished_frames(run.folder))));
  } catch (const InputError& error) {
    return {{"not scored", without_place(error.what(), work)}};
  }
}

/// One runner of one shard.
class Runner {
 public:
  Runner(const PlanReader& plan, Shard shard, const RunnerOptions& options)
      : plan_{plan},
        shard_{std::move(shard)},
        options_{options},
        places_{plan.folder(), shard_.digest},
        input_{plan_, shard_} {}

  int work() {
    try {
      if (is_done()) return exit_done;
      if (const auto failure{read_failure(places_.failed)}; failure && !retry(*failure)) return failure->exit_code;
      return io::with_path_errors([this] { return work_alone(); });
    } catch (const DeviceError& error) {
      return complain(exit_try_again, error.what());
    }
  }

 private:
  int complain(int code, const std::string& why) const {
    tell_on_stderr("shard {}: {}\n", shard_.number, why);
    return code;
  }

  /// Returns whether there is a result. Moves one without a proper done.json to damaged/.
  bool is_done() const {
    std::error_code error;
    if (!io::is_there(places_.result)) return false;
    try {
      const auto done{read_done(places_.result)};
      if (done && done->digest == shard_.digest) return true;
    } catch (const InputError& broken) {
      spdlog::warn("{}", broken.what());
    }
    const fs::path aside{plan_.folder() / "damaged" /
                         fmt::format("{}.{}", places_.result.filename().string(), getpid())};
    fs::create_directories(aside.parent_path(), error);
    fs::rename(places_.result, aside, error);
    spdlog::warn("shard {}: the result there is damaged, and now lies in {}", shard_.number, aside.string());
    return false;
  }

  bool retry(const Failure& failure) const {
    std::error_code error;
    if (options_.retry_poison) {
      fs::remove(places_.failed, error);
      fs::remove_all(places_.work, error);
      return true;
    }
    complain(failure.exit_code, fmt::format("not tried again: {} (--retry-poison tries)", failure.message));
    return false;
  }

  int refuse(int code, const std::string& why) const {
    write_failure(places_.failed, {shard_.digest, shard_.number, code, without_place(why, places_.work), host_name()});
    return complain(code, why);
  }

  int work_alone() {
    int code{exit_try_again};
    {
      const FolderLock lock{places_.work};
      if (!lock.warning().empty()) {
        spdlog::warn("{}", lock.warning());
        places_.work += fmt::format(".{}-{}", host_name(), getpid());
        io::create_folder(places_.work);
      }
      code = is_done() ? exit_done : work_here();
      if (code != exit_try_again && code != exit_bug) empty_work();
    }
    std::error_code error;
    fs::remove(places_.work, error);  // if it is empty; another runner may be in it already
    return code;
  }

  /// Removes all files but the lock.
  void empty_work() const {
    std::error_code error;
    for (const fs::path& entry : io::entries_of(places_.work)) {
      if (entry.filename() != ".lock") fs::remove_all(entry, error);
    }
  }

  int work_here() {
    if (interrupted() != 0) return exit_try_again;
    if (const std::string missing{input_.missing()}; !missing.empty()) {
      return complain(exit_try_again, missing + " is not there. Is the file system mounted on this machine?");
    }
    double before_s{0};
    std::ifstream{seconds_file()} >> before_s;
    const Clock::time_point start{Clock::now()};
    const auto seconds = [&] { return before_s + std::chrono::duration<double>(Clock::now() - start).count(); };
    const int code{attempt(seconds)};
    if (code == exit_try_again) io::write_file(seconds_file(), fmt::format("{}\n", seconds()));
    return code;
  }

  template <class Seconds>
  int process(Seconds seconds) {
    if (!input_.is_as_planned()) {
      return refuse(exit_input,
                    io::printable(shard_.input.front()) +
                        ": has changed since the plan was made. Make a new plan; with the same folder, unchanged "
                        "inputs are not processed again.");
    }
    const int code{run_anew_where_damaged()};
    if (code != exit_done) return exit_try_again;
    return finish(seconds);
  }

  template <class Seconds>
  int attempt(Seconds seconds) {
    try {
      return io::with_path_errors([&] { return process(seconds); });
    } catch (const ConfigError& error) {
      return refuse_if_planned(exit_usage, error.what());
    } catch (const InputError& error) {
      return refuse_if_planned(exit_input, error.what());
    } catch (const std::bad_alloc&) {
      return complain(exit_try_again, "out of memory");
    } catch (const DeviceError& error) {
      return complain(exit_try_again, error.what());
    } catch (const std::exception& error) {
      const std::string of_thread{thread_failure(error)};
      if (!of_thread.empty()) return complain(exit_try_again, of_thread);
      return complain(exit_bug, std::string{"internal error: "} + error.what());
    }
  }

  [[nodiscard]] RunOptions options_of_run() const { return run_options(plan_.plan(), shard_, run_folder()); }

  /// Records the shard as impossible, unless the input is missing or changed at the moment.
  int refuse_if_planned(int code, const std::string& why) const {
    if (input_.is_there()) return refuse(code, why);
    return complain(exit_try_again,
                    why + " The input is not as planned at the moment: try again when its file system is back.");
  }

  fs::path run_folder() const { return places_.work / "run"; }
  /// Holds the time that earlier runners of the shard reported.
  fs::path seconds_file() const { return places_.work / "seconds"; }

  /// Continues from another runner's checkpoint; begins anew where a machine that broke down has left it damaged.
  int run_anew_where_damaged() const {
    std::error_code error;
    const bool resumed{io::is_there(run_folder() / "run.json")};
    if (!resumed) fs::remove_all(run_folder(), error);
    try {
      const int code{run_quietly()};
      if (resumed && code == exit_done) check_grids();
      return code;
    } catch (const InputError& damaged) {
      if (!resumed || !input_.is_there()) throw;
      spdlog::warn("shard {}: begins anew, since its saved part is not usable: {}", shard_.number, damaged.what());
    } catch (const ConfigError& damaged) {
      if (!resumed || !input_.is_there()) throw;
    }
    fs::remove_all(run_folder(), error);
    return run_quietly();
  }

  int run_quietly() const {
    RunOptions options{options_of_run()};
    options.device.threads = options_.threads;
    options.input_wait_s = options_.input_wait_s;
    return run(options);
  }

  /// Reads every grid: the checksums show files that a machine that broke down has left half-written.
  void check_grids() const {
    for (const io::RunFrame& frame : io::read_run_frames(run_folder() / "frames.jsonl")) {
      static_cast<void>(io::read_npz(run_folder() / "grids" / (frame.name + ".npz")));
    }
  }

  /// Restarts the shard and throws DeviceError if the input differs from the plan: the `lost` part may be available
  /// later.
  void require_planned_input(const std::string& lost) const {
    if (input_.is_there()) return;
    std::error_code error;
    fs::remove_all(run_folder(), error);
    throw DeviceError{fmt::format("{}: has changed, or was away, while it was read: {}. The shard begins anew.",
                                  io::printable(shard_.input.front()), lost)};
  }

  /// Marks the shard for `batch status`, before its result is there.
  void note_skipped(std::uint64_t skipped) const {
    require_planned_input(fmt::format("{} of {} frames are skipped", skipped, shard_.end - shard_.first));
    io::create_folder(places_.skipped.parent_path());
    io::write_file(places_.skipped, "");
  }

  template <class Seconds>
  int finish(Seconds seconds) {
    const fs::path result{places_.work / "result"};
    const bool scored{is_evaluated(plan_.plan()) && finished_frames(run_folder()) > 0};
    const Json scores(scored ? scores_of(options_of_run(), places_.work) : Json{});
    Done done{make_result(run_folder(), result, {seconds(), scores})};
    done.digest = shard_.digest;
    done.cost = shard_.cost;
    if (done.skipped > 0) note_skipped(done.skipped);
    if (scores.contains("not scored")) require_planned_input("not scored");
    write_done(result, done);
    const bool first{publish(result, places_.result)};
    if (options_.report) {
      tell("shard {}: {} frames, {} of {} skipped, {:.1f} s{}\n", shard_.number, done.frames, done.skipped,
           shard_.end - shard_.first, done.seconds, first ? "" : "; another runner was faster, its result stays");
    }
    return exit_done;
  }

  const PlanReader& plan_;
  Shard shard_;
  const RunnerOptions& options_;
  ShardPlaces places_;
  PlannedInput input_;
};

}  // namespace

int run_shard(const PlanReader& plan, std::uint64_t number, const RunnerOptions& options) {
  if (interrupted() != 0) return exit_try_again;
  return Runner{plan, plan.shard(number), options}.work();
}

}  // namespace stereogrid::app::batch
