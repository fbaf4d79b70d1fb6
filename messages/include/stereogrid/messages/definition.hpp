// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/messages/message.hpp"

namespace stereogrid::messages {

/// Describes a message as ROS 2's .msg files do, from the list of its fields; see `definition_of`.
class STEREOGRID_EXPORT DefinitionWriter {
 public:
  /// The definition of `M`, then of each type that it uses, divided as MCAP's "ros2msg" has it.
  template <Message M>
  static std::string write() {
    DefinitionWriter writer;
    writer.add<M>();
    return writer.joined();
  }

  template <class T>
  void operator()(std::string_view name, const T& /*field*/) {
    add_field(name_of(static_cast<const T*>(nullptr)), name);
  }

 private:
  struct Section {
    std::string_view type_name;
    std::string fields;
  };

  void add_field(const std::string& type, std::string_view name);
  [[nodiscard]] bool has(std::string_view type_name) const;
  [[nodiscard]] std::string joined() const;
  static std::string name_in_definitions(std::string_view type_name);

  template <Message M>
  void add() {
    if (has(M::type_name)) return;
    const std::size_t outer{current_};
    current_ = sections_.size();
    sections_.push_back({M::type_name, {}});
    const M message{};
    message.visit_fields(*this);
    current_ = outer;
  }

  template <Primitive T>
  std::string name_of(const T* /*type*/) {
    if constexpr (std::is_same_v<T, bool>) return "bool";
    if constexpr (std::is_same_v<T, std::byte>) return "byte";
    const char* const kind{std::is_floating_point_v<T> ? "float" : std::is_signed_v<T> ? "int" : "uint"};
    return kind + std::to_string(8 * sizeof(T));
  }
  std::string name_of(const std::string* /*type*/) { return "string"; }
  template <class T>
  std::string name_of(const std::vector<T>* /*type*/) {
    return name_of(static_cast<const T*>(nullptr)) + "[]";
  }
  template <class T, std::size_t n>
  std::string name_of(const std::array<T, n>* /*type*/) {
    return name_of(static_cast<const T*>(nullptr)) + "[" + std::to_string(n) + "]";
  }
  template <Message M>
  std::string name_of(const M* /*type*/) {
    add<M>();
    return name_in_definitions(M::type_name);
  }

  std::vector<Section> sections_;
  std::size_t current_{0};
};

/// Definition of `M` for readers, schema encoding "ros2msg", without comments and constants.
template <Message M>
std::string_view definition_of() {
  static const std::string text{DefinitionWriter::write<M>()};
  return text;
}

}  // namespace stereogrid::messages
