// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "input/calibration/yaml_group.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

constexpr std::string_view space{" \t\r\n"};

class XmlReader {
 public:
  XmlReader(std::string file, std::string_view text) : file_{std::move(file)}, text_{text} {}

  /// The content of the outermost element.
  YAML::Node root() {
    skip_to_tag();
    const Tag tag{take_tag()};
    return tag.is_empty ? YAML::Node{YAML::NodeType::Map} : content(tag.name, 0);
  }

 private:
  struct Tag {
    std::string_view name;
    bool is_empty;
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError{file_, "is not XML as OpenCV writes it: " + what + ".", see_documentation};
  }

  std::string_view take_until(std::string_view end) {
    const std::size_t length{text_.find(end)};
    if (length == std::string_view::npos) fail("'" + std::string{end} + "' is missing");
    const std::string_view taken{text_.substr(0, length)};
    text_.remove_prefix(length + end.size());
    return taken;
  }

  /// Words before the next tag; declarations and comments are skipped.
  std::string skip_to_tag() {
    std::string words;
    for (;;) {
      words += take_until("<");
      if (text_.starts_with("!--")) {
        static_cast<void>(take_until("-->"));
      } else if (text_.starts_with("?") || text_.starts_with("!")) {
        static_cast<void>(take_until(">"));
      } else {
        return words;
      }
    }
  }

  Tag take_tag() {
    std::string_view tag{take_until(">")};
    const bool is_empty{tag.ends_with('/')};
    if (is_empty) tag.remove_suffix(1);
    const std::string_view name{tag.substr(0, tag.find_first_of(space))};
    if (name.empty()) fail("an element has no name");
    return {name, is_empty};
  }

  static YAML::Node words_of(std::string_view text) {
    YAML::Node words{YAML::NodeType::Sequence};
    for (;;) {
      text.remove_prefix(std::min(text.find_first_not_of(space), text.size()));
      if (text.empty()) break;
      const std::string_view word{text.substr(0, text.find_first_of(space))};
      text.remove_prefix(word.size());
      words.push_back(std::string{word});
    }
    if (words.size() != 1) return words;
    return YAML::Node{words[0].Scalar()};
  }

  YAML::Node content(std::string_view name, int depth) {
    constexpr int deepest{16};
    if (depth > deepest) fail("its elements are nested deeper than 16");
    YAML::Node node;
    std::string words;
    for (;;) {
      words += skip_to_tag();
      const Tag tag{take_tag()};
      if (tag.name.starts_with('/')) {
        if (tag.name.substr(1) != name) fail("'" + printable(name) + "' has no end");
        break;
      }
      const YAML::Node child{tag.is_empty ? YAML::Node{YAML::NodeType::Sequence} : content(tag.name, depth + 1)};
      if ((tag.name == "_" && node.IsMap()) || (tag.name != "_" && node.IsSequence())) {
        fail("'" + printable(name) + "' mixes elements with and without names");
      }
      if (tag.name == "_") {
        node.push_back(child);
      } else {
        node.force_insert(std::string{tag.name}, child);
      }
    }
    return node.IsNull() ? words_of(words) : node;
  }

  std::string file_;
  std::string_view text_;
};

}  // namespace

YAML::Node parse_xml(const std::string& file, std::string_view text) {
  return XmlReader{file, text}.root();
}

}  // namespace stereogrid::io
