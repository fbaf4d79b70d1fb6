// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/io/text.hpp"

// Templates over the type of JSON (nlohmann::json or ordered_json), so that this header needs no library.
namespace stereogrid::io {

/// JSON as text. Never throws: bytes that are not UTF-8, as in names of files, become U+FFFD. `indent` < 0: one line.
template <class Json>
[[nodiscard]] std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Whether brackets stand within more than 64 others. Walking through such JSON would use up the stack.
[[nodiscard]] STEREOGRID_EXPORT bool is_nested_too_deeply(std::string_view json);

/// Reads JSON and hands it to `take(const Json&)`. Whatever is wrong with the text, or with what `take` finds in it
/// (exceptions of the JSON library, or an InputError without file), becomes InputError(file, …, mend). `where`: such as
/// "line 3 ", put before what is wrong.
template <class Json, class Take>
void read_json(const std::string& file, std::string_view text, const std::string& where, const std::string& mend,
               Take&& take) {
  constexpr std::size_t longest{300};
  if (is_nested_too_deeply(text)) throw InputError{file, where + "is nested too deeply.", mend};
  try {
    const Json json(Json::parse(text));  // no braces: they would make a list of it
    take(json);
  } catch (const typename Json::exception& error) {
    throw InputError{file, where + "is not understood (" + printable(error.what(), longest) + ").", mend};
  } catch (const InputError& error) {
    throw InputError{file, where + "is not understood (" + printable(error.what(), longest) + ").", mend};
  }
}

/// A whole number of an object. Throws InputError without file: none there, or out of its range.
template <class Json>
[[nodiscard]] std::int64_t whole_number(const Json& object, const char* key, std::int64_t least, std::int64_t most) {
  const Json& value = object.at(key);
  const bool fits{value.is_number_unsigned()
                      ? value.template get<std::uint64_t>() <= static_cast<std::uint64_t>(INT64_MAX)
                      : value.is_number_integer()};
  const std::int64_t number{fits ? value.template get<std::int64_t>() : 0};
  if (fits && number >= least && number <= most) return number;
  throw InputError{std::string{"'"} + key + "' is not a whole number from " + std::to_string(least) + " to " +
                   std::to_string(most)};
}

/// Throws InputError without file where `value` is no number from -`most` to `most`.
template <class Json>
[[nodiscard]] double number_of(const Json& value, const std::string& name, double most) {
  const double number{value.is_number() ? value.template get<double>() : NAN};
  if (std::abs(number) <= most) return number;
  throw InputError{"'" + name + "' is out of range"};
}

/// The same for what an object holds under a key.
template <class Json>
[[nodiscard]] double number(const Json& object, const char* key, double most) {
  return number_of(object.at(key), key, most);
}

/// A grid that can be worked on: of finite, not too many cells. Throws as number().
template <class Json>
[[nodiscard]] GridGeometry grid_geometry(const Json& object) {
  constexpr double farthest_m{1e6};
  constexpr double smallest_cell_m{1e-3};
  constexpr double largest_cell_m{1e3};
  constexpr std::int64_t most_cells{5'000};
  const GridGeometry grid{number(object, "x_min_m", farthest_m), number(object, "y_min_m", farthest_m),
                          number(object, "cell_size_m", largest_cell_m),
                          static_cast<int>(whole_number(object, "nx", 1, most_cells)),
                          static_cast<int>(whole_number(object, "ny", 1, most_cells))};
  if (grid.cell_size_m < smallest_cell_m) throw InputError{"'cell_size_m' is below a millimetre"};
  return grid;
}

}  // namespace stereogrid::io
