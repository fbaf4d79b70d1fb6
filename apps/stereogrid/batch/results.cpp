// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/results.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>

#include "batch/sha256.hpp"
#include "locks/descriptor.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* done_file{"done.json"};
constexpr const char* timing_file{"timing.json"};
constexpr const char* mend{"Remove the folder: the shard then begins anew."};
constexpr std::int64_t most{1'000'000'000'000'000};

[[noreturn]] void cannot(const fs::path& path, const char* what, int error_number) {
  throw DeviceError{fmt::format("{}: {} ({}). Check the space there and the permissions, then run it again.",
                                io::printable_path(path), what, std::generic_category().message(error_number))};
}

void sync(const Descriptor& descriptor, const fs::path& path) {
  // some file systems return EINVAL for folders
  if (fsync(descriptor.get()) != 0 && errno != EINVAL) cannot(path, "cannot be brought to the disk", errno);
}

void sync_folder(const fs::path& folder) {
  const Descriptor descriptor{open_file(folder.c_str(), O_RDONLY | O_DIRECTORY)};
  if (descriptor.get() < 0) cannot(folder, "cannot be opened", errno);
  sync(descriptor, folder);
}

PartFile read_part(const fs::path& path, bool to_disk) {
  const Descriptor file{open_file(path.c_str(), O_RDONLY)};
  if (file.get() < 0) cannot(path, "cannot be opened", errno);
  std::array<char, 1 << 16> piece{};
  PartFile part;
  Sha256 sha;
  for (;;) {
    const ssize_t count{read(file.get(), piece.data(), piece.size())};
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) cannot(path, "cannot be read", errno);
    if (count == 0) break;
    sha.add({piece.data(), static_cast<std::size_t>(count)});
    part.bytes += static_cast<std::uint64_t>(count);
  }
  if (to_disk) sync(file, path);
  part.sha256 = sha.hex();
  return part;
}

std::vector<std::string> names_below(const fs::path& folder, bool to_disk) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator{folder}) {
    if (entry.is_directory()) {
      if (to_disk) sync_folder(entry.path());
    } else if (const std::string name{entry.path().lexically_relative(folder).generic_string()}; name != done_file) {
      names.push_back(name);
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

Json to_json(const Done& done) {
  Json files(Json::array());
  for (const PartFile& file : done.files) files.push_back({file.name, file.bytes, file.sha256});
  return {{"digest", done.digest},   {"content", done.content}, {"frames", done.frames}, {"skipped", done.skipped},
          {"seconds", done.seconds}, {"cost", done.cost},       {"files", files}};
}

Done done_of(const Json& json) {
  const auto count = [&](const char* key) { return static_cast<std::uint64_t>(io::whole_number(json, key, 0, most)); };
  Done done{.digest = json.at("digest"),
            .content = json.at("content"),
            .frames = count("frames"),
            .skipped = count("skipped"),
            .seconds = json.at("seconds").get<double>(),
            .cost = json.at("cost").get<double>(),
            .files = {}};
  for (const Json& file : json.at("files")) {
    if (!file.at(1).is_number_unsigned()) throw InputError{"a file's size is no whole number"};
    done.files.push_back({file.at(0), file.at(1), file.at(2)});
  }
  return done;
}

/// Copies run.json without the values that depend on the machine and the time, and returns those.
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
    // includes frames that --every leaves unwritten
    timing["frames"] = io::whole_number(run.at("frames"), "last", 0, 1'000'000'000) + 1 -
                       io::whole_number(run.at("frames"), "first", 0, 1'000'000'000) -
                       static_cast<std::int64_t>(done.skipped);
    io::write_file(to, io::json_text(run, 1) + '\n');
  });
  return timing;
}

/// Copies frames.jsonl without times.
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
  if (!io::is_folder(from)) return;
  io::create_folder(to);
  for (const fs::path& entry : io::entries_of(from)) {
    // temporary files of a killed run begin with a dot
    if (entry.filename().string().front() != '.') link_or_copy(entry, to / entry.filename());
  }
}

}  // namespace

ShardPlaces::ShardPlaces(const fs::path& plan, const std::string& digest) {
  const std::string name{digest.substr(0, 16)};
  const std::string among{name.substr(0, 3)};
  result = plan / "results" / among / name;
  work = plan / "work" / among / name;
  failed = plan / "failed" / among / (name + ".json");
  skipped = plan / "skipped" / among / name;
}

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
  if (!facts.figures.is_null()) io::write_file(result / "figures.json", io::json_text(facts.figures, 1) + '\n');
  timing["seconds"] = facts.seconds;
  timing["host"] = host_name();
  io::write_file(result / "timing.json", io::json_text(timing, 1) + '\n');
  done.seconds = facts.seconds;
  return done;
}

std::string content_digest(const std::vector<PartFile>& files) {
  Sha256 sha;
  for (const PartFile& file : files) {
    if (file.name != timing_file) sha.add(fmt::format("{} {}\n", file.sha256, file.name));
  }
  return sha.hex();
}

void write_done(const fs::path& folder, Done done) {
  done.files.clear();
  for (const std::string& name : names_below(folder, true)) {
    done.files.push_back(read_part(folder / name, true));
    done.files.back().name = name;
  }
  done.content = content_digest(done.files);
  io::write_file(folder / done_file, io::json_text(to_json(done)) + '\n');
  static_cast<void>(read_part(folder / done_file, true));
  sync_folder(folder);
}

std::optional<Done> read_done(const fs::path& folder) {
  const fs::path file{folder / done_file};
  if (!io::is_there(file)) return std::nullopt;
  Done done;
  io::read_json<Json>(io::printable_path(file), io::read_file(file), "", "Remove the folder, then run the shard again.",
                      [&](const Json& json) { done = done_of(json); });
  return done;
}

std::string difference(const fs::path& folder, const Done& done) {
  try {
    const std::vector<std::string> names{names_below(folder, false)};
    for (std::size_t i{0}; i < std::max(names.size(), done.files.size()); ++i) {
      const bool both{i < names.size() && i < done.files.size()};
      if (both && names[i] == done.files[i].name) continue;
      if (i >= names.size() || (both && done.files[i].name < names[i])) return done.files[i].name + " is missing";
      return names[i] + " does not belong there";
    }
    for (const PartFile& file : done.files) {
      const PartFile found{read_part(folder / file.name, false)};
      if (found.bytes != file.bytes) return fmt::format("{} has {} bytes, not {}", file.name, found.bytes, file.bytes);
      if (found.sha256 != file.sha256) return file.name + " has another checksum";
    }
    return content_digest(done.files) == done.content ? "" : "done.json contradicts itself";
  } catch (const DeviceError& error) {
    return error.what();
  }
}

bool publish(const fs::path& from, const fs::path& result) {
  io::create_folder(result.parent_path());
  if (std::rename(from.c_str(), result.c_str()) != 0) {
    if (errno == EEXIST || errno == ENOTEMPTY) return false;
    cannot(result, "the result cannot be put there", errno);
  }
  sync_folder(result.parent_path());
  return true;
}

void write_failure(const fs::path& file, const Failure& failure) {
  io::create_folder(file.parent_path());
  const Json json{{"digest", failure.digest},
                  {"shard", failure.shard},
                  {"exit_code", failure.exit_code},
                  {"message", failure.message},
                  {"host", failure.host}};
  io::write_file(file, io::json_text(json, 1) + '\n');
}

std::optional<Failure> read_failure(const fs::path& file) {
  if (!io::is_there(file)) return std::nullopt;
  Failure failure;
  io::read_json<Json>(
      io::printable_path(file), io::read_file(file), "", "Remove the file, then run the shard again.",
      [&](const Json& json) {
        failure = {json.at("digest"), static_cast<std::uint64_t>(io::whole_number(json, "shard", 0, most)),
                   static_cast<int>(io::whole_number(json, "exit_code", 0, 255)), json.at("message"), json.at("host")};
      });
  return failure;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? io::printable(name.data()) : "unknown";
}

}  // namespace stereogrid::app::batch
