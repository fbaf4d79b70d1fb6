// SPDX-License-Identifier: Apache-2.0
#include "input/poses/kitti_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

bool parse_numbers(std::string_view text, std::vector<double>& numbers) {
  numbers.clear();
  constexpr std::string_view space{" \t\r\n"};
  for (;;) {
    const std::size_t start{text.find_first_not_of(space)};
    if (start == std::string_view::npos) return true;
    text.remove_prefix(start);
    std::string_view word{text.substr(0, text.find_first_of(space))};
    text.remove_prefix(word.size());
    if (word.starts_with('+')) word.remove_prefix(1);
    double number{0};
    const auto [end, error]{std::from_chars(word.data(), word.data() + word.size(), number)};
    if (error == std::errc::result_out_of_range) number = 0;  // 1e-400
    if (error == std::errc::invalid_argument || end != word.data() + word.size()) return false;
    numbers.push_back(number);
  }
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    std::string_view line{text.substr(0, text.find('\n'))};
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
  }
  return lines;
}

bool is_rotation(const cv::Matx33d& matrix) {
  return cv::norm(matrix * matrix.t() - cv::Matx33d::eye(), cv::NORM_INF) < 0.01 && cv::determinant(matrix) > 0;
}

KittiText::KittiText(const std::filesystem::path& path) : file_{printable_path(path)} {
  const std::string text{read_text(path, largest_bytes::calibration)};
  for (const std::string_view line : lines_of(text)) {
    const std::size_t colon{line.find(':')};
    if (colon == std::string_view::npos) continue;
    std::vector<double> numbers;
    if (parse_numbers(line.substr(colon + 1), numbers)) values_[std::string{line.substr(0, colon)}] = numbers;
  }
}

const std::vector<double>& KittiText::get(const std::string& key, std::size_t count) const {
  const auto found{values_.find(key)};
  if (found == values_.end()) {
    throw InputError{file_, "has no line '" + key + ": …' of numbers.", "Use the calibration file of this recording."};
  }
  const auto& numbers{found->second};
  const bool finite{std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); })};
  if (numbers.size() != count || !finite) {
    throw InputError{file_,
                     finite ? "has " + std::to_string(numbers.size()) + " numbers in line '" + key + "', not " +
                                  std::to_string(count) + "."
                            : "has a number in line '" + key + "' that is not finite.",
                     "Use the calibration file of this recording."};
  }
  return numbers;
}

cv::Matx44d KittiText::rotation_and_translation() const {
  const auto& r{get("R", 9)};
  const auto& t{get("T", 3)};
  return {r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2], 0, 0, 0, 1};
}

cv::Matx44d KittiText::transform(const std::string& key) const {
  const auto& m{get(key, 12)};
  return {m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], 0, 0, 0, 1};
}

}  // namespace stereogrid::io
