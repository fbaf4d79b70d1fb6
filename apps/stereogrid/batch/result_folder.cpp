// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/result_folder.hpp"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* mend{"Remove the folder: the shard then begins anew."};

/// run.json without what is of one machine and one moment, which is returned.
Json split_run(const fs::path& from, const fs::path& to, Done& done) {
  Json timing(Json::object());
  const std::string text{io::read_file(from, io::largest_bytes::json)};
  io::read_json<Json>(io::printable_path(from), text, "", mend, [&](Json run) {
    for (const char* key : {"simd_target", "threads", "timing_ms"}) {
      if (run.contains(key)) timing[key] = run.at(key);
      run.erase(key);
    }
    done.frames = static_cast<std::uint64_t>(io::whole_number(run.at("frames"), "done", 0, 1'000'000'000));
    done.skipped = static_cast<std::uint64_t>(io::whole_number(run.at("frames"), "skipped", 0, 1'000'000'000));
    // those that --every has left unwritten, too
    timing["frames"] = io::whole_number(run.at("frames"), "last", 0, 1'000'000'000) + 1 -
                       io::whole_number(run.at("frames"), "first", 0, 1'000'000'000) -
                       static_cast<std::int64_t>(done.skipped);
    io::write_file(to, io::json_text(run, 1) + '\n');
  });
  return timing;
}

/// frames.jsonl without times.
void copy_lines(const fs::path& from, const fs::path& to) {
  std::ifstream lines{from, std::ios::binary};
  std::ofstream without_times{to, std::ios::binary | std::ios::trunc};
  int number{0};
  for (std::string line; std::getline(lines, line);) {
    io::read_json<Json>(io::printable_path(from), line, fmt::format("line {} ", ++number), mend, [&](Json frame) {
      frame["timing_ms"] = Json(Json::object());
      without_times << io::json_text(frame) << '\n';
    });
  }
  without_times.close();
  if (!without_times) {
    throw DeviceError{fmt::format("{}: cannot be written. Check the space there.", io::printable_path(to))};
  }
}

void link_folder(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (!fs::is_directory(from, error)) return;
  io::create_folder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator{from}) {
    // what a killed run has left of a file has a temporary name, which begins so
    if (entry.path().filename().string().front() != '.') link_or_copy(entry.path(), to / entry.path().filename());
  }
}

}  // namespace

void link_or_copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (!error) return;
  throw DeviceError{fmt::format("{}: cannot be copied to {} ({}). Check the space there.", io::printable_path(from),
                                io::printable_path(to), error.message())};
}

Done make_result(const fs::path& run, const fs::path& result, const RunFacts& facts) {
  std::error_code error;
  fs::remove_all(result, error);
  io::create_folder(result);
  Done done;
  Json timing(split_run(run / "run.json", result / "run.json", done));
  copy_lines(run / "frames.jsonl", result / "frames.jsonl");
  for (const char* folder : {"grids", "predictions", "stages", "pictures"}) link_folder(run / folder, result / folder);
  if (facts.keep_state && fs::exists(run / "state.npz", error)) link_or_copy(run / "state.npz", result / "state.npz");
  if (!facts.figures.is_null()) io::write_file(result / "figures.json", io::json_text(facts.figures, 1) + '\n');
  timing["seconds"] = facts.seconds;
  timing["host"] = host_name();
  io::write_file(result / "timing.json", io::json_text(timing, 1) + '\n');
  done.seconds = facts.seconds;
  return done;
}

}  // namespace stereogrid::app::batch
