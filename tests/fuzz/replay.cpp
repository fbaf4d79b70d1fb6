// SPDX-License-Identifier: Apache-2.0
//
// Usage: fuzz_replay FOLDER TARGET. Runs the target on every file of FOLDER/TARGET (seeds.py). An input that takes more
// than 10 s or 2 GB ends it (the fuzzers' limits).
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace {

namespace fs = std::filesystem;
using stereogrid::fuzz::Target;

std::vector<fs::path> inputs_of(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator{folder}) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

bool passes(const Target& target, const fs::path& file) {
  std::printf("%s\n", file.c_str());
  std::fflush(stdout);  // a crash leaves the name of what caused it
  ::alarm(10);
  const std::string bytes{stereogrid::io::read_file(file)};
  try {
    target.run({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    return true;
  } catch (const std::exception& error) {
    std::printf("  finding: %s\n", error.what());
    return false;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<Target>& targets{stereogrid::fuzz::targets()};
  const auto target{std::ranges::find_if(
      targets, [&](const Target& known) { return argc == 3 && std::string_view{known.name} == argv[2]; })};
  if (target == targets.end()) {
    std::fprintf(stderr, "Usage: fuzz_replay FOLDER TARGET\n");
    return 64;
  }
  const std::vector<fs::path> files{inputs_of(fs::path{argv[1]} / target->name)};
  if (files.empty()) std::printf("no inputs\n");
#ifndef __SANITIZE_ADDRESS__  // which reserves terabytes of addresses
  const rlimit most_memory{std::uint64_t{2} << 30, std::uint64_t{2} << 30};
  if (::setrlimit(RLIMIT_DATA, &most_memory) != 0) return 1;
#endif
  const auto failed{std::ranges::count_if(files, [&](const fs::path& file) { return !passes(*target, file); })};
  return failed == 0 && !files.empty() ? 0 : 1;
}
