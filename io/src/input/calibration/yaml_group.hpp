// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stereogrid::io {

inline constexpr const char* see_documentation{"docs/input.md shows what a calibration holds."};

/// Source of values, for messages: each is an InputError.
class Origin {
 public:
  /// `part`: of the file, "": all of it. `other_way`: sentence that every advice ends with; "": none.
  explicit Origin(std::string file, std::string part = "", std::string other_way = "")
      : file_{std::move(file)}, part_{std::move(part)}, other_way_{std::move(other_way)} {}

  [[nodiscard]] const std::string& file() const { return file_; }

  /// Names the part, too.
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(const std::string& what, const std::string& mend) const;

 protected:
  [[nodiscard]] const std::string& part() const { return part_; }
  /// Names the file only.
  [[noreturn]] void reject(const std::string& what) const;

 private:
  std::string file_;
  std::string part_;
  std::string other_way_;
};

/// Mapping of a YAML file with its position: errors are InputError with file, key and line.
class YamlGroup : public Origin {
 public:
  using Keys = std::initializer_list<std::string_view>;

  /// `known`: the keys that may stand there, others are refused; empty: others are passed over.
  YamlGroup(std::string file, std::string name, YAML::Node node, Keys known = {});

  [[nodiscard]] bool has(const char* key) const { return node_[key].IsDefined(); }
  /// True if a key has a list that holds no groups, such as names.
  [[nodiscard]] bool has_list(const char* key) const;
  /// Throws where one of the group's keys is not of these.
  void need_only(Keys known) const;

  [[nodiscard]] YamlGroup group(const char* key, Keys known = {}) const;
  /// An element of a list; `name` is its place, or the word before it ([word, group]).
  struct Element;
  [[nodiscard]] std::vector<Element> groups(const char* key) const;
  [[nodiscard]] std::vector<std::string> keys() const;
  /// The values of all groups within, called by their path (left.K).
  [[nodiscard]] YamlGroup flat() const;
  [[nodiscard]] double number(const char* key) const;
  [[nodiscard]] double number(const char* key, double otherwise) const { return has(key) ? number(key) : otherwise; }
  /// A number, a list of numbers, or a list of rows; at most 16.
  [[nodiscard]] std::vector<double> numbers(const char* key) const;
  [[nodiscard]] std::vector<double> numbers(const char* key, std::size_t count) const;
  /// {rows, cols, data} as ROS and OpenCV write it, or a list of numbers or rows; row-major.
  [[nodiscard]] std::vector<double> matrix(const char* key, int rows, int cols) const;
  /// The same of any shape.
  [[nodiscard]] std::vector<double> values(const char* key) const { return any_matrix(key).data; }
  /// The same of a single row or column of any length, none too.
  [[nodiscard]] std::vector<double> vector(const char* key) const;
  /// From 1 to 100 000.
  [[nodiscard]] int pixels(const char* key) const;
  [[nodiscard]] std::string word(const char* key) const;
  [[nodiscard]] std::filesystem::path file_name(const char* key) const;
  [[nodiscard]] std::vector<std::filesystem::path> file_names(const char* key) const;

 private:
  struct Matrix {
    double rows;
    double cols;
    std::vector<double> data;
  };

  [[nodiscard]] std::string full(const std::string& key) const { return part().empty() ? key : part() + "." + key; }
  [[nodiscard]] YAML::Node required(const char* key) const;
  [[nodiscard]] Matrix any_matrix(const char* key) const;
  [[nodiscard]] Matrix matrix_of_rows(const char* key) const;
  [[nodiscard]] double number_of(const YAML::Node& node, const char* key) const;
  [[nodiscard]] std::filesystem::path file_name_of(const YAML::Node& node, const char* key) const;

  YAML::Node node_;
};

struct YamlGroup::Element {
  std::string name;
  YamlGroup group;
};

/// The file's outermost mapping. OpenCV's first line, %YAML:1.0, which is no YAML, is passed over. Throws InputError:
/// no file, no YAML, no mapping.
[[nodiscard]] YamlGroup read_yaml(const std::filesystem::path& path);
/// The same of a text, JSON too, which is YAML.
[[nodiscard]] YamlGroup parse_yaml(const std::filesystem::path& path, std::string text);

/// Message for a YAML error of yaml-cpp.
inline std::string error_text_of(const YAML::Exception& error) {
  // its words for groups in groups beyond the depth that it can follow; of text in memory it says that of nothing else
  if (error.msg == "bad file") return "is nested too deeply.";
  return "is not YAML (" + error.msg + ").";
}

// Other notations than YAML as YAML's nodes, so that one set of readers serves all. Throw InputError; `file`: for
// error messages.

/// OpenCV's XML: elements become keys, words of a leaf a list, <_> elements of a list. Attributes have no effect.
[[nodiscard]] YAML::Node parse_xml(const std::string& file, std::string_view text);

/// [SECTION] and key=value, as ZED's SN*.conf: a group for each section.
[[nodiscard]] YAML::Node parse_sections(const std::string& file, std::string_view text);

/// key=value or key=[numbers; numbers], as Middlebury's calib.txt.
[[nodiscard]] YAML::Node parse_assignments(const std::string& file, std::string_view text);

/// Numbers alone: a matrix as key 'K'; two projection matrices as P1 and P2; nine of a camera matrix and a baseline, as
/// FoundationStereo's K.txt: fx fy cx cy baseline.
[[nodiscard]] YAML::Node parse_matrix(const std::string& file, std::string_view text);

/// COLMAP's cameras.txt: width, height, fx, fy, cx, cy and distortion of its camera. Throws InputError: cameras that
/// differ, or of another model than its pinhole, radial and OPENCV ones.
[[nodiscard]] YAML::Node parse_colmap(const std::string& file, std::string_view text);

/// Arrays of an .npz as lists, those of rows as lists of rows.
[[nodiscard]] YAML::Node parse_npz(const std::filesystem::path& path);

/// ost.txt of camera_calibration: key 'cameras' with a group of camera_info's keys for each camera.
[[nodiscard]] YAML::Node parse_ost(const std::string& file, std::string_view text);

}  // namespace stereogrid::io
