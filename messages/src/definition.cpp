// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/definition.hpp"

#include <algorithm>

namespace stereogrid::messages {

void DefinitionWriter::add_field(const std::string& type, std::string_view name) {
  sections_[current_].fields += type + " " + std::string{name} + "\n";
}

bool DefinitionWriter::has(std::string_view type_name) const {
  return std::ranges::any_of(sections_, [&](const Section& section) { return section.type_name == type_name; });
}

// "nav_msgs/msg/OccupancyGrid" is "nav_msgs/OccupancyGrid" there.
std::string DefinitionWriter::name_in_definitions(std::string_view type_name) {
  return std::string{type_name.substr(0, type_name.find('/'))} + std::string{type_name.substr(type_name.rfind('/'))};
}

std::string DefinitionWriter::joined() const {
  std::string text;
  for (const Section& section : sections_) {
    if (!text.empty()) text += std::string(80, '=') + "\nMSG: " + name_in_definitions(section.type_name) + "\n";
    text += section.fields;
  }
  return text;
}

}  // namespace stereogrid::messages
