// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/yaml_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

void Origin::fail(const std::string& what) const {
  fail(what, see_documentation);
}

void Origin::fail(const std::string& what, const std::string& mend) const {
  throw InputError{part_.empty() ? file_ : file_ + " (" + part_ + ")", what,
                   other_way_.empty() ? mend : mend + " " + other_way_};
}

void Origin::reject(const std::string& what) const {
  throw InputError{file_, what, see_documentation};
}

namespace {

constexpr std::size_t most_numbers{16};
constexpr double largest_number{1e9};

/// " in line 3"; "": a file whose lines are not counted.
std::string place_of(const YAML::Node& node) {
  return node.Mark().is_null() ? "" : fmt::format(" in line {}", node.Mark().line + 1);
}

/// OpenCV's dialect as YAML: its first line is a comment, so that error messages count lines as the file does; no blank
/// has to stand behind a key (data:[1, 2]).
std::string from_opencv(std::string_view text) {
  constexpr std::string_view in_keys{" abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-"};
  std::string result{"#"};
  text.remove_prefix(1);
  for (bool is_first{true}; !text.empty(); is_first = false) {
    const std::string_view line{text.substr(0, text.find('\n'))};
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::size_t colon{line.find_first_not_of(in_keys)};
    const bool is_key{!is_first && colon != std::string_view::npos && line[colon] == ':'};
    result +=
        is_key ? fmt::format("{}: {}\n", line.substr(0, colon), line.substr(colon + 1)) : fmt::format("{}\n", line);
  }
  return result;
}

/// Adds what `from` holds; a group with `data` is a matrix.
void add_flat(YAML::Node& to, const YAML::Node& from, const std::string& path, int depth) {
  constexpr int deepest{6};
  for (const auto& item : from) {
    if (!item.first.IsScalar()) continue;
    const std::string key{path + item.first.Scalar()};
    if (item.second.IsMap() && !item.second["data"].IsDefined() && depth < deepest) {
      add_flat(to, item.second, key + ".", depth + 1);
    } else {
      to.force_insert(key, item.second);
    }
  }
}

/// Keys that had other names.
void take_former_names(YAML::Node& node) {
  constexpr std::array<std::array<const char*, 2>, 3> names{
      {{"centre_u_px", "cx_px"}, {"centre_v_px", "cy_px"}, {"centre_u_right_px", "cx_right_px"}}};
  for (const auto& [former, now] : names) {
    const YAML::Node& present{node};  // operator[] of a constant node inserts nothing
    if (!present[former].IsDefined() || present[now].IsDefined()) continue;
    node[now] = present[former];
    node.remove(former);
  }
}

}  // namespace

YamlGroup::YamlGroup(std::string file, std::string name, YAML::Node node, Keys known)
    : Origin{std::move(file), std::move(name)}, node_{std::move(node)} {
  if (node_.IsMap()) take_former_names(node_);
  if (!node_.IsMap()) reject(part().empty() ? "is not a YAML mapping." : "'" + part() + "' is not a group of keys.");
  if (known.size() > 0) need_only(known);
}

namespace {

/// The known key whose name without its unit begins that of `key`; "": none.
std::string similar_key(std::string_view key, YamlGroup::Keys known) {
  for (const std::string_view name : known) {
    const std::size_t unit{name.rfind('_')};
    if (unit != std::string_view::npos && key.starts_with(name.substr(0, unit))) return std::string{name};
  }
  return {};
}

}  // namespace

void YamlGroup::need_only(Keys known) const {
  std::vector<std::string> seen;
  for (const auto& item : node_) {
    if (!item.first.IsScalar()) reject("has a key" + place_of(item.first) + " that is not a word.");
    const std::string& key{item.first.Scalar()};
    if (std::ranges::find(known, key) == known.end()) {
      const std::string meant{similar_key(key, known)};
      reject("has an unknown key '" + full(key) + "'" + place_of(item.first) +
             (meant.empty() ? "." : ". Is '" + meant + "' meant?"));
    }
    if (std::ranges::find(seen, key) != seen.end())
      reject("has '" + full(key) + "' again" + place_of(item.first) + ".");
    seen.push_back(key);
  }
}

YamlGroup YamlGroup::group(const char* key, Keys known) const {
  return {file(), full(key), required(key), known};
}

YamlGroup YamlGroup::flat() const {
  YAML::Node all{YAML::NodeType::Map};
  add_flat(all, node_, "", 0);
  return {file(), part(), all};
}

double YamlGroup::number(const char* key) const {
  return number_of(required(key), key);
}

std::vector<double> YamlGroup::numbers(const char* key) const {
  const YAML::Node value{required(key)};
  std::vector<double> numbers;
  if (value.IsScalar()) return {number_of(value, key)};
  if (!value.IsSequence()) reject("'" + full(key) + "' is not a list of numbers.");
  const auto take{[&](const YAML::Node& node) {
    if (numbers.size() == most_numbers)
      reject("'" + full(key) + "' has more than " + std::to_string(most_numbers) + " numbers.");
    numbers.push_back(number_of(node, key));
  }};
  for (const auto& item : value) {
    if (item.IsSequence()) {  // a matrix written as a list of rows
      for (const auto& element : item) take(element);
    } else {
      take(item);
    }
  }
  return numbers;
}

std::vector<double> YamlGroup::numbers(const char* key, std::size_t count) const {
  std::vector<double> found{numbers(key)};
  if (found.size() != count) reject(fmt::format("'{}' has {} numbers, not {}.", full(key), found.size(), count));
  return found;
}

std::vector<std::string> YamlGroup::keys() const {
  std::vector<std::string> found;
  for (const auto& item : node_) {
    if (item.first.IsScalar()) found.push_back(item.first.Scalar());
  }
  return found;
}

std::vector<YamlGroup::Element> YamlGroup::groups(const char* key) const {
  constexpr std::size_t most{64};
  const YAML::Node value{required(key)};
  if (!value.IsSequence() || value.size() > most) reject(fmt::format("'{}' is not a list of groups.", full(key)));
  std::vector<Element> found;
  for (const auto& item : value) {
    std::string name{std::to_string(found.size())};
    YAML::Node content{item};
    if (item.IsSequence() && item.size() == 2 && item[0].IsScalar()) {
      name = printable(item[0].Scalar());
      content.reset(item[1]);
    }
    found.push_back({name, YamlGroup{file(), fmt::format("{}.{}", full(key), name), content}});
  }
  return found;
}

YamlGroup::Matrix YamlGroup::any_matrix(const char* key) const {
  if (required(key).IsSequence()) return matrix_of_rows(key);
  const YamlGroup matrix{group(key)};
  Matrix found{matrix.number("rows"), matrix.number("cols"), matrix.numbers("data")};
  if (found.rows * found.cols != static_cast<double>(found.data.size())) {
    reject(
        fmt::format("'{}' has {} numbers, but {} rows of {}.", full(key), found.data.size(), found.rows, found.cols));
  }
  return found;
}

/// [[1, 2], [3, 4]], or [1, 2, 3, 4] as a single row.
YamlGroup::Matrix YamlGroup::matrix_of_rows(const char* key) const {
  const YAML::Node value{required(key)};
  std::vector<double> data{numbers(key)};
  const std::size_t rows{value.size() > 0 && value[0].IsSequence() ? value.size() : 1};
  if (data.size() % rows != 0) reject(fmt::format("'{}' has rows of different lengths.", full(key)));
  return {static_cast<double>(rows), static_cast<double>(data.size() / rows), std::move(data)};
}

std::vector<double> YamlGroup::matrix(const char* key, int rows, int cols) const {
  Matrix found{any_matrix(key)};
  const bool is_flat{found.rows == 1 && found.data.size() == static_cast<std::size_t>(rows * cols)};
  if (!is_flat && (found.rows != rows || found.cols != cols)) {
    reject(fmt::format("'{}' is a matrix of {} rows of {}, not of {} of {}.", full(key), found.rows, found.cols, rows,
                       cols));
  }
  return std::move(found.data);
}

std::vector<double> YamlGroup::vector(const char* key) const {
  Matrix found{any_matrix(key)};
  if (found.rows > 1 && found.cols > 1) reject("'" + full(key) + "' is neither a row nor a column of numbers.");
  return std::move(found.data);
}

int YamlGroup::pixels(const char* key) const {
  const double value{number(key)};
  if (value != std::floor(value) || value < 1 || value > 100000) reject("'" + full(key) + "' is not a size in pixels.");
  return static_cast<int>(value);
}

std::string YamlGroup::word(const char* key) const {
  const YAML::Node value{required(key)};
  if (!value.IsScalar()) reject("'" + full(key) + "'" + place_of(value) + " is not a word.");
  return value.Scalar();
}

std::filesystem::path YamlGroup::file_name(const char* key) const {
  return file_name_of(required(key), key);
}

bool YamlGroup::has_list(const char* key) const {
  const YAML::Node value{node_[key]};
  return value.IsDefined() && value.IsSequence() &&
         std::none_of(value.begin(), value.end(), [](const auto& item) { return item.IsMap() || item.IsSequence(); });
}

std::vector<std::filesystem::path> YamlGroup::file_names(const char* key) const {
  const YAML::Node value{required(key)};
  if (!value.IsSequence()) return {file_name_of(value, key)};
  std::vector<std::filesystem::path> names;
  for (const auto& item : value) names.push_back(file_name_of(item, key));
  return names;
}

YAML::Node YamlGroup::required(const char* key) const {
  const YAML::Node found{node_[key]};
  if (!found.IsDefined()) reject("has no '" + full(key) + "'.");
  return found;
}

double YamlGroup::number_of(const YAML::Node& node, const char* key) const {
  std::vector<double> numbers;
  if (!node.IsScalar() || !parse_numbers(node.Scalar(), numbers) || numbers.size() != 1 ||
      !(std::abs(numbers[0]) <= largest_number)) {
    reject("'" + full(key) + "'" + place_of(node) + " is not a number.");
  }
  return numbers[0];
}

std::filesystem::path YamlGroup::file_name_of(const YAML::Node& node, const char* key) const {
  if (!node.IsScalar() || node.Scalar().empty() || node.Scalar().find('\0') != std::string::npos) {
    reject("'" + full(key) + "'" + place_of(node) + " is not a file's name.");
  }
  return node.Scalar();
}

YamlGroup read_yaml(const std::filesystem::path& path) {
  return parse_yaml(path, read_text(path, largest_bytes::calibration));
}

YamlGroup parse_yaml(const std::filesystem::path& path, std::string text) {
  if (text.starts_with("%YAML:")) text = from_opencv(text);
  try {
    return {printable_path(path), "", YAML::Load(text)};
  } catch (const YAML::Exception& error) {
    throw InputError{printable_path(path), fmt::format("line {} {}", error.mark.line + 1, error_text_of(error)),
                     see_documentation};
  }
}

}  // namespace stereogrid::io
