// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/yaml_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::io {
namespace {

constexpr std::size_t most_entries{2000};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space{" \t\r"};
  text.remove_prefix(std::min(text.find_first_not_of(space), text.size()));
  return text.substr(0, text.find_last_not_of(space) + 1);
}

[[noreturn]] void fail(const std::string& file, std::size_t line, const std::string& what) {
  throw InputError{file, fmt::format("line {} {}", line, what), see_documentation};
}

/// Lines without blanks around them, with their numbers; comments are empty.
std::vector<std::string_view> entries_of(const std::string& file, std::string_view text) {
  std::vector<std::string_view> lines{lines_of(text)};
  if (lines.size() > most_entries) throw InputError{file, "has more than 2000 lines.", see_documentation};
  for (std::string_view& line : lines) {
    line = trimmed(line);
    if (line.starts_with('#') || line.starts_with(';')) line = {};
  }
  return lines;
}

/// "1 2; 3 4" as a list of numbers.
YAML::Node list_of(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == ';' || c == ',' || c == '[' || c == ']'; }, ' ');
  std::vector<double> numbers;
  YAML::Node list{YAML::NodeType::Sequence};
  if (!parse_numbers(text, numbers)) return YAML::Node{text};
  for (const double number : numbers) list.push_back(fmt::format("{}", number));
  return list;
}

struct Assignment {
  std::string_view key;
  std::string_view value;
};

Assignment assignment_of(const std::string& file, std::size_t number, std::string_view line) {
  const std::size_t equals{line.find('=')};
  if (equals == std::string_view::npos) fail(file, number, "is no key=value.");
  return {trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1))};
}

struct OstMatrix {
  std::string_view title;
  const char* key;
  int cols;
};

constexpr std::array<OstMatrix, 4> ost_matrices{{{"camera matrix", "camera_matrix", 3},
                                                 {"distortion", "distortion_coefficients", 0},
                                                 {"rectification", "rectification_matrix", 3},
                                                 {"projection", "projection_matrix", 4}}};

/// {rows, cols, data} of rows of numbers; `cols` 0: a single row.
YAML::Node ost_matrix(const std::string& numbers, int cols) {
  YAML::Node matrix;
  const YAML::Node data{list_of(numbers)};
  const std::size_t count{data.IsSequence() ? data.size() : 0};
  matrix["rows"] = cols == 0 ? 1 : count / static_cast<std::size_t>(cols);
  matrix["cols"] = cols == 0 ? count : static_cast<std::size_t>(cols);
  matrix["data"] = data;
  return matrix;
}

YAML::Node ost_camera(std::span<const std::string_view> lines) {
  YAML::Node camera{YAML::NodeType::Map};
  for (std::size_t i{0}; i < lines.size(); ++i) {
    const std::string_view line{lines[i]};
    if (line.starts_with('[') && line.ends_with(']')) {
      camera["camera_name"] = std::string{line.substr(1, line.size() - 2)};
    } else if ((line == "width" || line == "height") && i + 1 < lines.size()) {
      camera["image_" + std::string{line}] = std::string{lines[i + 1]};
    }
    const auto matrix{std::ranges::find(ost_matrices, line, &OstMatrix::title)};
    if (matrix == ost_matrices.end()) continue;
    std::string numbers;
    for (std::size_t row{i + 1}; row < lines.size() && !lines[row].empty(); ++row) {
      numbers += std::string{lines[row]} + ' ';
    }
    camera[matrix->key] = ost_matrix(numbers, matrix->cols);
  }
  if (camera["distortion_coefficients"]["data"].size() > 5) camera["distortion_model"] = "rational_polynomial";
  return camera;
}

}  // namespace

YAML::Node parse_sections(const std::string& file, std::string_view text) {
  YAML::Node root{YAML::NodeType::Map};
  YAML::Node section{YAML::NodeType::Map};
  const std::vector<std::string_view> lines{entries_of(file, text)};
  for (std::size_t i{0}; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    if (lines[i].starts_with('[') && lines[i].ends_with(']')) {
      section.reset(YAML::Node{YAML::NodeType::Map});
      root.force_insert(std::string{lines[i].substr(1, lines[i].size() - 2)}, section);
      continue;
    }
    const Assignment found{assignment_of(file, i + 1, lines[i])};
    section.force_insert(std::string{found.key}, std::string{found.value});
  }
  return root;
}

YAML::Node parse_assignments(const std::string& file, std::string_view text) {
  YAML::Node root{YAML::NodeType::Map};
  const std::vector<std::string_view> lines{entries_of(file, text)};
  for (std::size_t i{0}; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    const Assignment found{assignment_of(file, i + 1, lines[i])};
    const std::string value{found.value};
    root.force_insert(std::string{found.key}, value.starts_with('[') ? list_of(value) : YAML::Node{value});
  }
  return root;
}

YAML::Node parse_ost(const std::string& file, std::string_view text) {
  YAML::Node cameras{YAML::NodeType::Sequence};
  const std::vector<std::string_view> lines{entries_of(file, text)};
  const auto first_of_camera{[&](auto from) { return std::find(from, lines.end(), "[image]"); }};
  for (auto begin{first_of_camera(lines.begin())}; begin != lines.end();) {
    const auto end{first_of_camera(begin + 1)};
    cameras.push_back(ost_camera({begin + 1, end}));
    begin = end;
  }
  YAML::Node root{YAML::NodeType::Map};
  root["cameras"] = cameras;
  return root;
}

}  // namespace stereogrid::io
