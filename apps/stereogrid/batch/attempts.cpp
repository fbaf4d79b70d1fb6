// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/attempts.hpp"

#include <fstream>
#include <string>
#include <system_error>

#include "batch/plan.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/json_text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* name{"attempts.json"};

}  // namespace

Attempts read_attempts(const fs::path& work) {
  Attempts attempts;
  std::error_code error;
  if (!fs::exists(work / name, error)) return attempts;
  try {
    io::read_json<Json>(name, io::read_file(work / name), "", "", [&](const Json& json) {
      attempts = {static_cast<int>(io::whole_number(json, "without_progress", 0, 1000)),
                  static_cast<std::uint64_t>(io::whole_number(json, "frames", 0, 1'000'000'000)),
                  json.at("seconds").get<double>()};
    });
  } catch (const InputError&) {
    return {};
  }
  return attempts;
}

void write_attempts(const fs::path& work, const Attempts& attempts) {
  const Json json{
      {"without_progress", attempts.without_progress}, {"frames", attempts.frames}, {"seconds", attempts.seconds}};
  io::write_file(work / name, io::json_text(json) + '\n');
}

Attempts begin_attempt(Attempts before, std::uint64_t frames) {
  if (frames > before.frames) before.without_progress = 0;
  ++before.without_progress;
  before.frames = frames;
  return before;
}

std::uint64_t finished_frames(const fs::path& run) {
  std::ifstream file{run / "frames.jsonl", std::ios::binary};
  std::uint64_t lines{0};
  for (std::string line; std::getline(file, line);) lines += file.eof() ? 0 : 1;
  return lines;
}

}  // namespace stereogrid::app::batch
