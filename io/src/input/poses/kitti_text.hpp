// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <opencv2/core/matx.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace stereogrid::io {

/// White-space separated numbers; a decimal point whatever the locale, "nan" and "inf" too. False: something else is
/// there.
[[nodiscard]] bool parse_numbers(std::string_view text, std::vector<double>& numbers);

/// Lines without their ends (\n or \r\n); a last line without an end counts.
[[nodiscard]] std::vector<std::string_view> lines_of(std::string_view text);

/// True: orthonormal to 1 %, and no reflection.
[[nodiscard]] bool is_rotation(const cv::Matx33d& matrix);

/// KITTI's calibration files: lines "KEY: numbers". Lines whose value is no list of numbers (dates) are left out.
class KittiText {
 public:
  /// Throws InputError where the file cannot be read.
  explicit KittiText(const std::filesystem::path& path);

  [[nodiscard]] bool has(const std::string& key) const { return values_.contains(key); }
  /// Throws InputError: no such key, not `count` numbers, a number that is not finite.
  [[nodiscard]] const std::vector<double>& get(const std::string& key, std::size_t count) const;
  /// A rigid transform from R and T.
  [[nodiscard]] cv::Matx44d rotation_and_translation() const;
  /// A 3 × 4 rigid transform.
  [[nodiscard]] cv::Matx44d transform(const std::string& key) const;

 private:
  std::string file_;
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace stereogrid::io
