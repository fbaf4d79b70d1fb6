// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

#include <algorithm>
#include <cctype>

#include "stereogrid/error.hpp"

namespace stereogrid::dds {
namespace {

constexpr std::string_view default_node{"/stereo_grid/"};
constexpr std::string_view topics{"rt"};
constexpr std::string_view of_dds{"::dds_::"};
constexpr std::string_view between{"::"};

bool is_letter(char letter) {
  return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_';
}

/// Names with / between them.
bool is_path(std::string_view path) {
  for (;;) {
    const std::string_view name{path.substr(0, path.find('/'))};
    if (name.empty() || !std::ranges::all_of(name, is_letter)) return false;
    if (std::isdigit(static_cast<unsigned char>(name.front())) != 0) return false;
    if (name.size() == path.size()) return true;
    path.remove_prefix(name.size() + 1);
  }
}

std::string_view without_slash(std::string_view path) {
  return path.starts_with('/') ? path.substr(1) : path;
}

std::string replaced(std::string_view text, std::string_view what, std::string_view by) {
  std::string changed{text};
  for (std::size_t at{changed.find(what)}; at != std::string::npos; at = changed.find(what, at + by.size())) {
    changed.replace(at, what.size(), by);
  }
  return changed;
}

}  // namespace

Names::Names(const NodeOptions& options) {
  const std::string_view path{without_slash(options.name)};
  if (!is_path(path)) {
    throw ConfigError{"\"" + options.name +
                      "\" is not a name of a ROS 2 node: letters, digits and _, no digit first, with / between names."};
  }
  const std::size_t slash{path.rfind('/')};
  namespace_ = "/" + std::string{slash == std::string_view::npos ? "" : path.substr(0, slash)};
  node_ = slash == std::string_view::npos ? path : path.substr(slash + 1);
  for (const std::string& text : options.remappings) add_remapping(text);
}

void Names::add_remapping(const std::string& text) {
  const std::size_t at{text.find(":=")};
  const std::string_view from{std::string_view{text}.substr(0, at)};
  const std::string_view to{at == std::string::npos ? std::string_view{} : std::string_view{text}.substr(at + 2)};
  if (!is_path(without_slash(from)) || !is_path(without_slash(to))) {
    throw ConfigError{"\"" + text + "\" is not a remapping: FROM:=TO, such as occupancy_grid:=/map or /tf:=/robot/tf."};
  }
  remappings_.emplace_back(below_node(from), below_node(to));
}

std::string Names::below_node(std::string_view name) const {
  if (name.starts_with('/')) return std::string{name};
  return (namespace_ == "/" ? "" : namespace_) + "/" + node_ + "/" + std::string{name};
}

std::string Names::topic(std::string_view given) const {
  if (given.starts_with(default_node)) given.remove_prefix(default_node.size());
  return remapped(below_node(given));
}

std::string Names::remapped(const std::string& name) const {
  const auto found{std::ranges::find(remappings_, name, &std::pair<std::string, std::string>::first)};
  return found == remappings_.end() ? name : found->second;
}

std::string dds_topic(std::string_view ros_topic) {
  return std::string{topics} + std::string{ros_topic};
}

std::string dds_type(std::string_view ros_type) {
  const std::size_t slash{ros_type.rfind('/')};
  if (slash == std::string_view::npos) return std::string{ros_type};
  return replaced(ros_type.substr(0, slash), "/", between) + std::string{of_dds} +
         std::string{ros_type.substr(slash + 1)} + "_";
}

std::optional<PublishedTopic> ros_topic(std::string_view dds_topic, std::string_view dds_type) {
  const std::size_t at{dds_type.find(of_dds)};
  if (!dds_topic.starts_with(std::string{topics} + "/") || at == std::string_view::npos || !dds_type.ends_with('_')) {
    return std::nullopt;
  }
  const std::string_view last{dds_type.substr(at + of_dds.size())};
  std::string name{dds_topic.substr(topics.size())};
  std::string type{replaced(dds_type.substr(0, at), between, "/") + "/" + std::string{last.substr(0, last.size() - 1)}};
  if (!is_path(without_slash(name)) || !is_path(type)) return std::nullopt;
  return PublishedTopic{std::move(name), std::move(type), 1};
}

}  // namespace stereogrid::dds
