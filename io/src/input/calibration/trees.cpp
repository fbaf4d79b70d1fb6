// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/yaml_group.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/text.hpp"

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
  if (equals == std::string_view::npos) fail(file, number, "is not key=value.");
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

namespace {

/// True for fx 0 cx tx, 0 fy cy ty, 0 0 1 tz in px, and false for a pose.
bool is_projection(std::span<const double> p) {
  constexpr double shortest_px{2};
  return p[0] > shortest_px && p[1] == 0 && p[4] == 0 && p[5] > shortest_px && p[8] == 0 && p[9] == 0 && p[10] == 1;
}

}  // namespace

YAML::Node parse_matrix(const std::string& file, std::string_view text) {
  std::string numbers{text};
  std::ranges::replace_if(
      numbers, [](char c) { return c == '\n' || c == '\r' || c == ','; }, ' ');
  std::vector<double> k;
  if (!parse_numbers(numbers, k) || k.empty()) throw InputError{file, "holds no numbers.", see_documentation};
  YAML::Node root{YAML::NodeType::Map};
  constexpr std::size_t with_baseline{10};
  const bool is_camera{k.size() == with_baseline && k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1};
  constexpr std::size_t of_projection{12};
  const std::span<const double> all{k};
  if (k.size() == 2 * of_projection && is_projection(all.first(of_projection)) &&
      is_projection(all.last(of_projection))) {
    for (const auto& [key, p] : {std::pair{"P1", all.first(of_projection)}, std::pair{"P2", all.last(of_projection)}}) {
      for (const double number : p) root[key].push_back(fmt::format("{}", number));
    }
    return root;
  }
  if (!is_camera) {
    root["K"] = list_of(numbers);
    return root;
  }
  const auto add{[&](const char* key, double number) { root[key] = fmt::format("{}", number); }};
  add("fx", k[0]);
  add("fy", k[4]);
  add("cx", k[2]);
  add("cy", k[5]);
  add("baseline", k[9]);
  return root;
}

YAML::Node parse_colmap(const std::string& file, std::string_view text) {
  struct Model {
    std::string_view name;
    std::size_t focals;
    std::size_t distortions;  // behind the principal point: k1 k2 p1 p2
  };
  constexpr std::array<Model, 5> models{
      {{"SIMPLE_PINHOLE", 1, 0}, {"PINHOLE", 2, 0}, {"SIMPLE_RADIAL", 1, 1}, {"RADIAL", 1, 2}, {"OPENCV", 2, 4}}};
  constexpr double corner_px{0.5};  // the corner of the first pixel is (0, 0)
  YAML::Node root{YAML::NodeType::Map};
  std::string first;
  for (const std::string_view line : entries_of(file, text)) {
    if (line.empty()) continue;
    std::istringstream words{std::string{line}};
    std::string id;
    std::string name;
    std::string width;
    std::string height;
    std::string parameters;
    words >> id >> name >> width >> height;
    std::getline(words, parameters);
    std::vector<double> k;
    const auto model{std::ranges::find(models, std::string_view{name}, &Model::name)};
    if (model == models.end() || !parse_numbers(parameters, k) || k.size() != model->focals + 2 + model->distortions) {
      throw InputError{file, "is COLMAP's list of cameras, with another model: " + printable(name) + ".",
                       "Undistort the images (colmap image_undistorter), and give their cameras.txt."};
    }
    const std::string camera{fmt::format("{} {} {}", width, height, parameters)};
    if (first.empty()) first = camera;
    if (camera != first) {
      throw InputError{file, "is COLMAP's list of cameras, which differ.",
                       "Rectify the pair: both have one camera then."};
    }
    root["width"] = width;
    root["height"] = height;
    root["fx"] = fmt::format("{}", k[0]);
    root["fy"] = fmt::format("{}", k[model->focals - 1]);
    root["cx"] = fmt::format("{}", k[model->focals] - corner_px);
    root["cy"] = fmt::format("{}", k[model->focals + 1] - corner_px);
    k.erase(k.begin(), k.begin() + static_cast<std::ptrdiff_t>(model->focals + 2));
    k.resize(4);
    root["distortion"] = list_of(fmt::format("{}", fmt::join(k, " ")));
  }
  return root;
}

namespace {

/// A scalar, a list, or a list of rows.
YAML::Node list_of(const NpyArray& array) {
  const std::vector<double> numbers{array.to<double>()};
  if (array.shape.empty() && numbers.size() == 1) return YAML::Node{fmt::format("{}", numbers[0])};
  YAML::Node list{YAML::NodeType::Sequence};
  if (array.shape.size() != 2) {
    for (const double number : numbers) list.push_back(fmt::format("{}", number));
    return list;
  }
  for (std::size_t row{0}; row < array.shape[0]; ++row) {
    YAML::Node columns{YAML::NodeType::Sequence};
    for (std::size_t i{0}; i < array.shape[1]; ++i) {
      columns.push_back(fmt::format("{}", numbers[row * array.shape[1] + i]));
    }
    list.push_back(columns);
  }
  return list;
}

}  // namespace

YAML::Node parse_npz(const std::filesystem::path& path) {
  constexpr std::size_t most_elements{100};  // larger arrays are maps or images
  YAML::Node root{YAML::NodeType::Map};
  for (const auto& [name, array] : read_npz(path)) {
    root.force_insert(name, array.size() <= most_elements ? list_of(array) : YAML::Node{"array"});
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
