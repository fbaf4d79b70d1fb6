// SPDX-License-Identifier: Apache-2.0
//
// Times writing of MCAP files against fwrite() of the same messages, in turns within one run, and prints the ratios.
// The least of several times counts, of processor time. The argument is a folder, best one in memory (such as that of
// POSIX shared memory), so that no disk is measured. Messages are occupancy grids of 15 000 cells, or transforms of 100
// bytes.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <functional>
#include <random>
#include <vector>

#include "stereogrid/mcap/writer.hpp"

namespace {

namespace fs = std::filesystem;
using namespace stereogrid::mcap;

constexpr int rounds{5};
constexpr std::size_t total_bytes{std::size_t{128} << 20};

using Bytes = std::vector<std::byte>;

/// Unknown mostly, with patches of noisy occupancy, as a grid has them.
std::vector<Bytes> grids() {
  std::mt19937 random{1};
  std::vector<Bytes> grids(16, Bytes(15'000, std::byte{255}));
  for (Bytes& grid : grids) {
    for (int patch{0}; patch < 60; ++patch) {
      const std::size_t begin{random() % (grid.size() - 100)};
      for (std::size_t i{begin}; i < begin + 100; ++i) grid[i] = static_cast<std::byte>(random() % 20);
    }
  }
  return grids;
}

std::vector<Bytes> transforms() {
  std::mt19937 random{2};
  std::vector<Bytes> transforms(64, Bytes(100));
  for (Bytes& transform : transforms) {
    for (std::size_t i{0}; i < transform.size(); ++i) transform[i] = static_cast<std::byte>(i % 8 < 5 ? random() : i);
  }
  return transforms;
}

void write_mcap(const fs::path& path, const std::vector<Bytes>& messages, std::size_t count, Compression compression) {
  Writer writer{path, {.compression = compression}};
  const std::uint16_t channel{writer.add_channel("/x", "cdr", 0, {})};
  for (std::size_t i{0}; i < count; ++i) {
    writer.write(channel, static_cast<std::uint32_t>(i), i * 1000, i * 1000, messages[i % messages.size()]);
  }
  writer.close();
}

void write_plainly(const fs::path& path, const std::vector<Bytes>& messages, std::size_t count) {
  std::FILE* const file{std::fopen(path.c_str(), "wb")};
  if (file == nullptr) throw std::runtime_error{"cannot write " + path.string()};
  for (std::size_t i{0}; i < count; ++i) {
    std::fwrite(messages[i % messages.size()].data(), 1, messages[i % messages.size()].size(), file);
  }
  std::fclose(file);
}

double seconds_of(const std::function<void()>& work) {
  const std::clock_t start{std::clock()};
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

void compare(const char* name, const std::vector<Bytes>& messages, const fs::path& folder) {
  const std::size_t count{total_bytes / messages[0].size()};
  struct Way {
    const char* name;
    std::function<void(const fs::path&)> write;
    double seconds{1e9};
    std::uintmax_t bytes{0};
  };
  const auto mcap = [&](Compression compression) {
    return [&messages, count, compression](const fs::path& path) { write_mcap(path, messages, count, compression); };
  };
  std::vector<Way> ways{{"fwrite", [&](const fs::path& path) { write_plainly(path, messages, count); }},
                        {"none", mcap(Compression::none)},
                        {"lz4", mcap(Compression::lz4)},
                        {"zstd", mcap(Compression::zstd)}};
  const fs::path path{folder / "stereogrid_bench.mcap"};
  for (int round{0}; round < rounds; ++round) {
    for (Way& way : ways) {
      way.seconds = std::min(way.seconds, seconds_of([&] { way.write(path); }));
      way.bytes = fs::file_size(path);
      fs::remove(path);
    }
  }
  for (const Way& way : ways) {
    const auto whole{static_cast<double>(count * messages[0].size())};
    std::printf("| %s | %s | %.0f | %.0f | %.2f | %.2f |\n", name, way.name, 1e-6 * whole / way.seconds,
                static_cast<double>(count) / way.seconds, way.seconds / ways[0].seconds,
                static_cast<double>(way.bytes) / whole);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const fs::path folder{argc > 1 ? fs::path{argv[1]} : fs::temp_directory_path()};
    std::printf("| messages | written by | MB/s | messages/s | time / fwrite | bytes in the file / of messages |\n");
    std::printf("| --- | --- | --- | --- | --- | --- |\n");
    compare("grids, 15 000 B", grids(), folder);
    compare("transforms, 100 B", transforms(), folder);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
