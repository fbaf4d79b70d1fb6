// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/scratch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view begins_with{"stereogrid-fetched-"};

template <class Take>
void for_each_scratch(const fs::path& shared, Take take) {
  std::error_code error;
  for (fs::directory_iterator at{shared, error}; !error && at != fs::directory_iterator{}; at.increment(error)) {
    if (at->path().filename().string().starts_with(begins_with)) take(at->path());
  }
}

/// While it is held nobody makes or clears away scratch folders.
Descriptor hold(const fs::path& shared) {
  Descriptor all{open_file((shared / ".stereogrid-fetched.lock").c_str(), O_RDWR | O_CREAT)};
  while (all.get() >= 0 && flock(all.get(), LOCK_EX) != 0 && errno == EINTR) {
  }
  return all;
}

void clear_away_dead(const fs::path& shared) {
  for_each_scratch(shared, [](const fs::path& folder) {
    std::error_code error;
    try {
      const FolderLock lock{folder};
      if (lock.keeps_others_out()) fs::remove_all(folder, error);
    } catch (const DeviceError&) {
      return;  // somebody works there
    }
  });
}

}  // namespace

ScratchFolder::ScratchFolder(const fs::path& shared) {
  io::create_folder(shared);
  const Descriptor held{hold(shared)};
  clear_away_dead(shared);
  std::string name{(shared / begins_with).string() + "XXXXXX"};
  if (mkdtemp(name.data()) == nullptr) {
    throw DeviceError{fmt::format("{}: no folder can be made there ({}). Check --scratch.", io::printable_path(shared),
                                  std::generic_category().message(errno))};
  }
  path_ = name;
  lock_.emplace(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code error;
  fs::remove_all(path_, error);
}

std::uint64_t scratch_bytes(const fs::path& shared) {
  std::uint64_t bytes{0};
  for_each_scratch(shared, [&bytes](const fs::path& folder) {
    std::error_code error;
    for (fs::recursive_directory_iterator at{folder, error}; !error && at != fs::recursive_directory_iterator{};
         at.increment(error)) {
      std::error_code gone;
      const std::uintmax_t size{at->is_regular_file(gone) ? at->file_size(gone) : 0};
      if (!gone) bytes += size;
    }
  });
  return bytes;
}

std::uint64_t bytes_of(const std::string& size) {
  constexpr std::string_view units{"KMGT"};
  std::uint64_t number{0};
  const char* const end{size.data() + size.size()};
  const auto [stop, error]{std::from_chars(size.data(), end, number)};
  const std::size_t unit{stop + 1 == end ? units.find(*stop) : std::string_view::npos};
  constexpr std::uint64_t most{1'000'000'000'000'000};
  std::uint64_t bytes{number};
  if (unit != std::string_view::npos) {
    for (std::size_t i{0}; i <= unit && bytes <= most; ++i) bytes *= 1000;
  }
  if (error == std::errc{} && (stop == end || unit != std::string_view::npos) && bytes > 0 && bytes <= most)
    return bytes;
  throw ConfigError{fmt::format("{} is no size. Give bytes, or a number with K, M, G or T: 50G.", io::printable(size))};
}

}  // namespace stereogrid::app::batch
