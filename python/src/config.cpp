// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/config.hpp"

#include <nanobind/operators.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <cctype>
#include <deque>
#include <string>
#include <type_traits>

#include "bindings.hpp"
#include "stereogrid/io/config_file.hpp"

namespace stereogrid::python {
namespace {

namespace nb = nanobind;

/// Text with the lifetime of the process, for names and docstrings.
const char* kept(std::string text) {
  static std::deque<std::string> texts;
  return texts.emplace_back(std::move(text)).c_str();
}

/// "u_disparity": "UDisparityConfig".
std::string class_name(std::string_view group) {
  std::string name;
  bool begins_word{true};
  for (const char c : group) {
    if (c != '_') name += begins_word ? static_cast<char>(std::toupper(c)) : c;
    begins_word = c == '_';
  }
  return name + "Config";
}

std::string text_of(const Parameter& parameter) {
  std::string text{parameter.sentence};
  if (!parameter.unit.empty()) text += " Unit: " + std::string{parameter.unit} + ".";
  return text;
}

/// Value of a setting as Python has it: choices are their names.
template <class T>
nb::object to_python(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return nb::cast(names_of(value)[static_cast<std::size_t>(value)]);
  } else {
    return nb::cast(value);
  }
}

/// Text that set() reads.
std::string setting_text(nb::handle value) {
  if (nb::isinstance<nb::list>(value) || nb::isinstance<nb::tuple>(value)) {
    std::string text;
    for (const nb::handle item : value) text += (text.empty() ? "" : ",") + setting_text(item);
    return text;
  }
  if (nb::isinstance<nb::bool_>(value)) return nb::cast<bool>(value) ? "true" : "false";
  return nb::cast<std::string>(nb::str(value));
}

template <class T, class Group>
T* find(Group& fields, std::string_view name) {
  T* found{nullptr};
  Group::visit_fields(fields, [&](const Parameter& parameter, auto& value) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, std::remove_const_t<T>>) {
      if (parameter.name == name) found = &value;
    }
  });
  return found;
}

template <class Group>
Group& group_of(Config& config) {
  Group* found{nullptr};
  Config::visit_groups(config, [&](std::string_view, auto& fields) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(fields)>, Group>) found = &fields;
  });
  return *found;
}

/// Sets a field as Config.set() does.
template <class Group>
void set_field(Group& fields, const char* key, nb::handle value) {
  Config config;
  group_of<Group>(config) = fields;
  set(config, key, setting_text(value));
  fields = group_of<Group>(config);
}

template <class T>
const char* type_name() {
  if constexpr (std::is_same_v<T, bool>) return "bool";
  if constexpr (std::is_integral_v<T>) return "int";
  if constexpr (std::is_floating_point_v<T>) return "float";
  return std::is_enum_v<T> ? "str" : "list[float]";
}

template <class Group>
void bind_group(nb::module_& module, nb::class_<Config>& config, std::string_view name) {
  const std::string class_text{class_name(name)};
  nb::class_<Group> group{module, kept(class_text), kept("Parameters of the group " + std::string{name} + ".")};
  Group fields;
  Group::visit_fields(fields, [&](const Parameter& parameter, auto& sample) {
    using T = std::remove_cvref_t<decltype(sample)>;
    const char* const field{kept(std::string{parameter.name})};
    const char* const key{kept(std::string{name} + "." + field)};
    const std::string type{type_name<T>()};
    group.def_prop_rw(
        field, [field](const Group& self) { return to_python(*find<const T>(self, field)); },
        [key](Group& self, nb::handle value) { set_field(self, key, value); },
        nb::for_getter(nb::sig(kept("def " + std::string{field} + "(self) -> " + type))),
        nb::for_setter(nb::sig(kept("def " + std::string{field} + "(self, value: " + type + " | str, /) -> None"))),
        kept(text_of(parameter)));
  });
  config.def_prop_ro(
      kept(std::string{name}), [](Config& self) -> Group& { return group_of<Group>(self); },
      nb::rv_policy::reference_internal, kept("Parameters of the group " + std::string{name} + "."));
}

std::vector<std::string> keys() {
  std::vector<std::string> names;
  const Config config;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    names.push_back(std::string{group} + "." + std::string{parameter.name});
  });
  return names;
}

nb::object value_of(const Config& config, std::string_view key) {
  nb::object found;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto& value) {
    if (key == std::string{group} + "." + std::string{parameter.name}) found = to_python(value);
  });
  if (!found) return nb::cast(get(config, key));  // a former key, or ConfigError
  return found;
}

std::vector<std::string> texts(const Config& config) {
  std::vector<std::string> values;
  for (const std::string& key : keys()) values.push_back(get(config, key));
  return values;
}

void set_state(Config& config, const std::vector<std::string>& values) {
  new (&config) Config{};
  const std::vector<std::string> names{keys()};
  for (std::size_t i{0}; i < names.size(); ++i) set(config, names[i], values.at(i));
}

}  // namespace

void bind_config(nb::module_& module) {
  nb::class_<Config> config{module, "Config",
                            "Parameters of a pipeline, by groups: config.grid.cell_size_m = 0.1. Values are checked by "
                            "Pipeline."};
  const Config sample;
  Config::visit_groups(sample, [&](std::string_view name, const auto& fields) {
    bind_group<std::remove_cvref_t<decltype(fields)>>(module, config, name);
  });
  config.def(nb::init<>(), "As the C++ declarations have it: the preset default.");
  config.def(
      "set", [](Config& self, std::string_view key, nb::handle value) { set(self, key, setting_text(value)); },
      nb::arg("key"), nb::arg("value"),
      nb::sig("def set(self, key: str, value: str | float | bool | list[float]) -> None"),
      "Sets a parameter by its key, such as \"grid.cell_size_m\". Raises ConfigError.");
  config.def("get", &value_of, nb::arg("key"), nb::sig("def get(self, key: str) -> Any"),
             "Returns the value of a key. Raises ConfigError.");
  config.def(
      "load", [](Config& self, const std::filesystem::path& path) { io::load_config(path, self); }, nb::arg("path"),
      "Sets every parameter that a YAML file names. Raises ConfigError, InputError.");
  config.def("to_yaml", &io::to_yaml, "Returns YAML that load() reads, with unit, range and text of each parameter.");
  config.def(
      "to_json", [](const Config& self) { return io::to_json(self); }, "Returns JSON as in a run's run.json.");
  config.def(
      "problems", [](const Config& self) { return problems(self); },
      "Returns what is wrong with the configuration; empty: nothing.");
  config.def_static("keys", &keys, "Returns the keys of all parameters.");
  config.def(
      "copy", [](const Config& self) { return Config{self}; }, "Returns a copy.");
  config.def("__copy__", [](const Config& self) { return Config{self}; });
  config.def(
      "__deepcopy__", [](const Config& self, nb::handle) { return Config{self}; }, nb::arg("memo"));
  config.def("__getstate__", &texts);
  config.def("__setstate__", &set_state);
  config.def(
      "__eq__", [](const Config& self, const Config& other) { return texts(self) == texts(other); }, nb::arg("other"),
      nb::is_operator(), nb::sig("def __eq__(self, other: object, /) -> bool"));
  config.def("__repr__", [](const Config& self) { return "stereogrid.Config(" + io::to_json(self) + ")"; });
  module.def("preset", &preset, nb::arg("name"), "Returns the configuration of a preset. Raises ConfigError.");
  module.def("preset_names", &preset_names, "Returns the names of the presets.");
}

}  // namespace stereogrid::python
