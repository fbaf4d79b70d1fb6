// SPDX-License-Identifier: Apache-2.0
#include "input/poses/recording_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>

#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
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

StampUnit stamp_unit(std::span<const double> stamps, const StampUnit& nominal, const std::string& source) {
  constexpr double slowest_hz{0.1};
  constexpr double fastest_hz{1000};
  // Usual rates span less than a factor of 1000: at most one unit gives one of them.
  constexpr double usual_slowest_hz{0.5};
  constexpr double usual_fastest_hz{250};
  constexpr double counted{1.5};  // ns
  std::vector<double> steps;
  double largest{0};
  for (std::size_t i{0}; i < stamps.size(); ++i) {
    if (i > 0) steps.push_back(stamps[i] - stamps[i - 1]);
    largest = std::max(largest, std::abs(stamps[i]));
  }
  const auto middle{steps.begin() + static_cast<std::ptrdiff_t>(steps.empty() ? 0 : (steps.size() - 1) / 2)};
  std::ranges::nth_element(steps, middle);
  const double step{steps.empty() ? 0 : *middle};
  const auto rate_hz{[step](const StampUnit& unit) { return 1e9 / (step * static_cast<double>(unit.ns)); }};
  const auto is_in_range{[largest](const StampUnit& unit) {
    return largest * static_cast<double>(unit.ns) <= static_cast<double>(largest_stamp_ns);
  }};
  StampUnit chosen{nominal};
  if (!(step > 0) && is_in_range(nominal)) return chosen;  // one frame, or an order that the caller rejects
  if (is_in_range(nominal) && rate_hz(nominal) >= slowest_hz && rate_hz(nominal) <= fastest_hz) return chosen;
  if (is_in_range(nominal) && step * static_cast<double>(nominal.ns) < counted) {
    chosen.note = "stamps: a nanosecond apart, as if frames had been counted; times and speeds mean nothing";
    return chosen;
  }
  for (const StampUnit& unit : stamp_units) {
    if (!is_in_range(unit) || rate_hz(unit) < usual_slowest_hz || rate_hz(unit) > usual_fastest_hz) continue;
    chosen = unit;
    chosen.note = fmt::format("stamps: taken as {}, in which frames come at {:.4g} Hz; {} would be {:.3g} Hz",
                              unit.name, rate_hz(unit), nominal.name, rate_hz(nominal));
    return chosen;
  }
  const std::string finding{
      is_in_range(nominal)
          ? fmt::format("stamps are {:.3g} {} apart, {:.3g} Hz (allowed up to 1000 Hz), and no other unit gives a "
                        "camera's rate.",
                        step, nominal.name, rate_hz(nominal))
          : fmt::format("a stamp of {:.4g} {} lies beyond the year 2096, and no other unit gives a camera's rate.",
                        largest, nominal.name)};
  if (!is_in_range(nominal) || rate_hz(nominal) > fastest_hz) {
    throw InputError{source, finding, "Stamps are seconds in times.txt, nanoseconds in poses.csv and in names."};
  }
  chosen.warning = fmt::format(
      "{}: frames come at {:.3g} Hz, as hardly any camera's do. Stamps are seconds in times.txt, nanoseconds "
      "in poses.csv.",
      source, rate_hz(nominal));
  return chosen;
}

Times read_times(const std::filesystem::path& path, std::size_t expected) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<double> times;
  std::vector<double> numbers;
  for (const std::string_view line : lines_of(text)) {
    const bool understood{parse_numbers(line, numbers)};
    if (understood && numbers.empty()) continue;
    if (!understood || numbers.size() != 1 || !(std::abs(numbers[0]) <= static_cast<double>(largest_stamp_ns))) {
      fail(path, times.size() + 1, "is not a number of seconds.", without_stamps);
    }
    times.push_back(numbers[0]);
  }
  if (times.size() != expected) {
    throw InputError{printable_path(path),
                     fmt::format("has {} times, but there are {} frames.", times.size(), expected),
                     "There has to be a line per frame (frames.txt says which frames the lines belong to)."};
  }
  const StampUnit unit{stamp_unit(times, stamp_units.back(), printable_path(path))};
  Times read{{}, unit.note, {}};
  constexpr std::size_t fewest{3};
  const auto counts_from = [&times](double first) {
    for (std::size_t i{0}; i < times.size(); ++i) {
      if (times[i] != first + static_cast<double>(i)) return false;
    }
    return true;
  };
  if (times.size() >= fewest && (counts_from(0) || counts_from(1))) {
    read.warning = printable_path(path) +
                   ": the stamps count the frames, and are taken as seconds. Write the seconds, or remove the file: 10 "
                   "frames a second are assumed then.";
  }
  for (const double time : times) read.stamps_ns.push_back(std::llround(time * static_cast<double>(unit.ns)));
  check_growing(path, read.stamps_ns, without_stamps);
  return read;
}

std::vector<std::int64_t> read_timestamps(const std::filesystem::path& path, const char* mend) {
  const std::string text{read_text(path, largest_bytes::lines)};
  std::vector<std::int64_t> stamps;
  for (const std::string_view line : lines_of(text)) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    const auto stamp{parse_timestamp(line)};
    if (!stamp) fail(path, stamps.size() + 1, "is not a time stamp like 2011-09-26 13:02:25.964389445.", mend);
    stamps.push_back(*stamp);
  }
  check_growing(path, stamps, mend);
  return stamps;
}

namespace {

/// Stamp (ns) of a date such as 20231128223057123, year to millisecond; none: another number.
std::optional<std::int64_t> stamp_of_date(const std::string& digits) {
  constexpr std::size_t count{17};
  if (digits.size() != count || !digits.starts_with("20") ||
      digits.find_first_not_of("0123456789") != std::string::npos) {
    return std::nullopt;
  }
  const auto part{[&](std::size_t at, std::size_t length) { return digits.substr(at, length); }};
  return parse_timestamp(fmt::format("{}-{}-{} {}:{}:{}.{}", part(0, 4), part(4, 2), part(6, 2), part(8, 2),
                                     part(10, 2), part(12, 2), part(14, 3)));
}

}  // namespace

std::optional<std::int64_t> stamp_in(std::string_view name) {
  name.remove_prefix(name.find_last_of("_-") + 1);  // 0 where there is none
  constexpr std::string_view digits_only{"0123456789"};
  constexpr std::size_t milliseconds{13};  // since 1970, of this century; numbers with leading zeros count frames
  const std::size_t dot{name.find('.')};
  std::string digits{name.substr(0, dot)};
  if (dot != std::string_view::npos) {
    std::string fraction{name.substr(dot + 1)};
    if (digits.size() < 9 || digits.size() > 10 || fraction.size() < 3 || fraction.size() > 9) return std::nullopt;
    fraction.resize(9, '0');
    digits += fraction;
  }
  if (const auto date{stamp_of_date(digits)}) return date;
  const bool is_long{digits.size() >= 16 && digits.size() <= 19};
  const bool is_of_milliseconds{digits.size() == milliseconds && digits[0] != '0'};
  if (!(is_long || is_of_milliseconds) || digits.find_first_not_of(digits_only) != std::string::npos) {
    return std::nullopt;
  }
  std::int64_t stamp{0};
  const auto [end, error]{std::from_chars(digits.data(), digits.data() + digits.size(), stamp)};
  return error == std::errc{} && stamp <= largest_stamp_ns ? std::optional{stamp} : std::nullopt;
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

namespace {

namespace fs = std::filesystem;

/// Stamps by name. False: the frames are not all named in the file.
bool take_stamps(RecordingContents& contents, const std::vector<NamedPose>& rows) {
  std::map<std::string, std::int64_t> stamps;
  for (const NamedPose& row : rows) stamps[row.name] = row.stamp_ns;
  for (RecordedFrame& frame : contents.frames) {
    const auto found{stamps.find(frame.name)};
    if (found == stamps.end()) return false;
    frame.stamp_ns = found->second;
  }
  return true;
}

void take_stamps(RecordingContents& contents, const std::vector<std::int64_t>& stamps) {
  for (std::size_t i{0}; i < stamps.size(); ++i) contents.frames[i].stamp_ns = stamps[i];
}

/// Line i of timestamps.txt belongs to the image of number i: single images of a drive may have been left out.
bool take_numbered_stamps(RecordingContents& contents, const std::vector<std::int64_t>& stamps) {
  for (RecordedFrame& frame : contents.frames) {
    std::size_t number{0};
    const auto [end, error]{std::from_chars(frame.name.data(), frame.name.data() + frame.name.size(), number)};
    if (error != std::errc{} || *end != '\0' || number >= stamps.size()) return false;
    frame.stamp_ns = stamps[number];
  }
  return true;
}

/// By the list of a EuRoC folder, else as the frames' names are. False: not all have some.
bool take_own_stamps(RecordingContents& contents, const InputLayout& layout) {
  const fs::path list{layout.left.parent_path() / "data.csv"};
  std::map<std::string, std::int64_t> listed;
  if (layout.kind == InputKind::euroc && is_there(list)) listed = read_euroc_stamps(list);
  for (RecordedFrame& frame : contents.frames) {
    const auto found{listed.find(frame.name)};
    const auto stamp_ns{found == listed.end() ? stamp_in(frame.name) : std::optional{found->second}};
    if (!stamp_ns) return false;
    frame.stamp_ns = *stamp_ns;
  }
  contents.notes.emplace_back(listed.empty() ? "stamps: the names of the images" : "stamps: " + printable_path(list));
  return true;
}

fs::path stamps_file(const InputLayout& layout, const std::string& poses) {
  std::vector<fs::path> candidates{layout.root / "times.txt", layout.root / "poses.csv"};
  if (layout.kind == InputKind::plain_folder) std::ranges::reverse(candidates);
  if (layout.kind == InputKind::kitti_raw) candidates = {layout.left.parent_path() / "timestamps.txt"};
  if (layout.kind == InputKind::image_pair) candidates.clear();
  if (fs::path{poses}.extension() == ".csv") candidates.emplace_back(poses);
  const auto gives_stamps = [](const fs::path& path) {
    return is_there(path) && (path.extension() != ".csv" || are_named(read_poses_csv(path)));
  };
  const auto found{std::ranges::find_if(candidates, gives_stamps)};
  return found == candidates.end() ? fs::path{} : *found;
}

void check_stamps_grow(const RecordingContents& contents, const fs::path& file) {
  for (std::size_t i{1}; i < contents.frames.size(); ++i) {
    if (contents.frames[i].stamp_ns > contents.frames[i - 1].stamp_ns) continue;
    throw InputError{
        printable_path(file),
        fmt::format("frame {} is not later than frame {}.", contents.frames[i].name, contents.frames[i - 1].name),
        "Frames are taken in the order of their names; their stamps have to grow."};
  }
}

}  // namespace

void settle_stamps(RecordingContents& contents, const fs::path& file) {
  std::vector<double> stamps;
  for (const RecordedFrame& frame : contents.frames) stamps.push_back(static_cast<double>(frame.stamp_ns));
  const StampUnit unit{stamp_unit(stamps, stamp_units.front(), printable_path(file))};
  for (RecordedFrame& frame : contents.frames) frame.stamp_ns *= unit.ns;
  if (!unit.note.empty()) contents.notes.push_back(unit.note);
  if (!unit.warning.empty()) contents.warnings.push_back(unit.warning);
}

bool find_stamps(RecordingContents& contents, const InputLayout& layout, const std::string& poses) {
  const fs::path file{stamps_file(layout, poses)};
  bool known{!file.empty()};
  if (file.filename() == "times.txt") {
    const Times times{read_times(file, contents.frames.size())};
    take_stamps(contents, times.stamps_ns);
    if (!times.note.empty()) contents.notes.push_back(times.note);
    if (!times.warning.empty()) contents.warnings.push_back(times.warning);
  } else if (file.filename() == "timestamps.txt") {
    known = take_numbered_stamps(contents, read_timestamps(file));
  } else if (known) {
    known = take_stamps(contents, read_poses_csv(file));
  }
  if (known) {
    contents.notes.push_back("stamps: " + printable_path(file));
  } else if (!take_own_stamps(contents, layout)) {
    for (std::size_t i{0}; i < contents.frames.size(); ++i) {
      contents.frames[i].stamp_ns = static_cast<std::int64_t>(i) * 100'000'000;
    }
    if (contents.frames.size() > 1) contents.notes.push_back("stamps: none, 10 frames a second assumed");
    return false;
  }
  const fs::path& source{known ? file : layout.left};
  check_stamps_grow(contents, source);
  settle_stamps(contents, source);
  return true;
}

}  // namespace stereogrid::io
