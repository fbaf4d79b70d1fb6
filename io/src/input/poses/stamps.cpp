// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/poses/recording_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

const char* const without_stamps{"Correct it, or remove the file: 10 frames a second are assumed then."};

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::size_t line, const std::string& what, const char* mend) {
  throw InputError{printable_path(path), "line " + std::to_string(line) + " " + what, mend};
}

void check_growing(const std::filesystem::path& path, const std::vector<std::int64_t>& stamps, const char* mend) {
  for (std::size_t i{1}; i < stamps.size(); ++i) {
    if (stamps[i] <= stamps[i - 1]) fail(path, i + 1, "is not later than the line before.", mend);
  }
}

/// Digits at a fixed place; a shorter fraction of a second is filled up with zeros.
std::optional<int> digits(std::string_view text, std::size_t at, std::size_t count) {
  if (text.size() < at + count) return std::nullopt;
  int value{0};
  const auto [end, error]{std::from_chars(text.data() + at, text.data() + at + count, value)};
  return error == std::errc{} && end == text.data() + at + count ? std::optional{value} : std::nullopt;
}

std::optional<std::int64_t> parse_timestamp(std::string_view text) {
  const auto year{digits(text, 0, 4)}, month{digits(text, 5, 2)}, day{digits(text, 8, 2)};
  const auto hour{digits(text, 11, 2)}, minute{digits(text, 14, 2)}, second{digits(text, 17, 2)};
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  if (*year < 1850 || *year > 2090) return std::nullopt;  // so that nanoseconds and their differences fit into 64 bits
  const std::chrono::year_month_day date{std::chrono::year{*year}, std::chrono::month{static_cast<unsigned>(*month)},
                                         std::chrono::day{static_cast<unsigned>(*day)}};
  if (!date.ok()) return std::nullopt;
  std::string fraction{text.size() > 20 && text[19] == '.' ? text.substr(20, 9) : std::string_view{}};
  fraction.resize(9, '0');
  const auto nanoseconds{digits(fraction, 0, 9)};
  if (!nanoseconds) return std::nullopt;
  const std::int64_t days{std::chrono::sys_days{date}.time_since_epoch().count()};
  const std::int64_t seconds{((days * 24 + *hour) * 60 + *minute) * 60 + *second};
  return seconds * 1'000'000'000 + *nanoseconds;
}

}  // namespace

std::vector<std::int64_t> read_times(const std::filesystem::path& path, std::size_t expected) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<std::int64_t> stamps;
  std::vector<double> numbers;
  for (const std::string_view line : lines_of(text)) {
    const bool understood{parse_numbers(line, numbers)};
    if (understood && numbers.empty()) continue;
    if (!understood || numbers.size() != 1 || !(std::abs(numbers[0]) < 4e9)) {
      fail(path, stamps.size() + 1, "is no number of seconds.", without_stamps);
    }
    stamps.push_back(std::llround(numbers[0] * 1e9));
  }
  if (stamps.size() != expected) {
    throw InputError{printable_path(path),
                     fmt::format("has {} times, but there are {} frames.", stamps.size(), expected),
                     "There has to be a line per frame (frames.txt says which frames the lines belong to)."};
  }
  check_growing(path, stamps, without_stamps);
  return stamps;
}

std::vector<std::int64_t> read_timestamps(const std::filesystem::path& path, const char* mend) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<std::int64_t> stamps;
  for (const std::string_view line : lines_of(text)) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    const auto stamp{parse_timestamp(line)};
    if (!stamp) fail(path, stamps.size() + 1, "is no time stamp like 2011-09-26 13:02:25.964389445.", mend);
    stamps.push_back(*stamp);
  }
  check_growing(path, stamps, mend);
  return stamps;
}

std::optional<std::int64_t> stamp_in(std::string_view name) {
  constexpr std::string_view digits_only{"0123456789"};
  const std::size_t dot{name.find('.')};
  std::string digits{name.substr(0, dot)};
  if (dot != std::string_view::npos) {
    std::string fraction{name.substr(dot + 1)};
    if (digits.size() < 9 || digits.size() > 10 || fraction.size() < 3 || fraction.size() > 9) return std::nullopt;
    fraction.resize(9, '0');
    digits += fraction;
  }
  if (digits.size() < 16 || digits.size() > 19 || digits.find_first_not_of(digits_only) != std::string::npos) {
    return std::nullopt;
  }
  std::int64_t stamp_ns{0};
  const auto [end, error]{std::from_chars(digits.data(), digits.data() + digits.size(), stamp_ns)};
  return error == std::errc{} && stamp_ns <= largest_stamp_ns ? std::optional{stamp_ns} : std::nullopt;
}

std::map<std::string, std::int64_t> read_euroc_stamps(const std::filesystem::path& path) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::map<std::string, std::int64_t> stamps;
  std::size_t number{0};
  for (std::string_view line : lines_of(text)) {
    ++number;
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.empty() || line.starts_with('#')) continue;
    std::int64_t stamp_ns{0};
    const auto [end, error]{std::from_chars(line.data(), line.data() + line.size(), stamp_ns)};
    const std::size_t comma{line.find(',')};
    if (error != std::errc{} || comma == std::string_view::npos || std::abs(stamp_ns) > largest_stamp_ns) {
      if (number == 1) continue;  // a header without #
      fail(path, number, "is not 'timestamp [ns],filename'.", without_stamps);
    }
    std::string_view file{line.substr(comma + 1)};
    file.remove_prefix(std::min(file.find_first_not_of(" \t"), file.size()));
    file = file.substr(0, file.find_last_not_of(" \t") + 1);
    stamps[frame_name(std::filesystem::path{file}.stem().string())] = stamp_ns;
  }
  return stamps;
}

}  // namespace stereogrid::io
