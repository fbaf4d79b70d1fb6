// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/obstacle.hpp"

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <type_traits>
#include <vector>

#include "bindings.hpp"
#include "pipeline.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"

namespace stereogrid::python {
namespace {

namespace nb = nanobind;

using Matrix2 = nb::ndarray<nb::numpy, double, nb::shape<2, 2>>;
using Points = nb::ndarray<nb::numpy, const double, nb::shape<-1, 2>>;

Matrix2 matrix_of(const Covariance2& c) {
  auto* const values{new std::array<double, 4>{c.xx, c.xy, c.xy, c.yy}};
  const nb::capsule owner{values, [](void* p) noexcept { delete static_cast<std::array<double, 4>*>(p); }};
  return {values->data(), {2, 2}, owner};
}

Points points_of(nb::handle self) {
  static_assert(sizeof(Point2) == 2 * sizeof(double));
  const Outline& outline{nb::cast<const Obstacle&>(self).outline};
  return {reinterpret_cast<const double*>(outline.begin()), {outline.size(), 2}, self};
}

template <class T>
const T& find(const Obstacle& obstacle, std::string_view name) {
  const T* found{nullptr};
  io::visit_fields(obstacle, [&](const io::ObstacleField& field, const auto& value) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, T>) {
      if (name == field.name) found = &value;
    }
  });
  return *found;
}

template <class T>
auto to_python(const T& value) {
  if constexpr (std::is_same_v<T, Covariance2>) {
    return matrix_of(value);
  } else if constexpr (std::is_same_v<T, ObstacleKind>) {
    return names_of(value)[static_cast<std::size_t>(value)];
  } else {
    return value;
  }
}

/// Array of a field of all obstacles; kinds are a list of texts.
template <class T>
nb::object column_of(const std::vector<Obstacle>& obstacles, std::string_view name) {
  if constexpr (std::is_same_v<T, ObstacleKind>) {
    nb::list texts;
    for (const Obstacle& obstacle : obstacles) texts.append(nb::cast(to_python(find<T>(obstacle, name))));
    return texts;
  } else {
    auto* const values{new T[obstacles.size()]};
    const nb::capsule owner{values, [](void* p) noexcept { delete[] static_cast<T*>(p); }};
    std::ranges::transform(obstacles, values, [name](const Obstacle& obstacle) { return find<T>(obstacle, name); });
    return nb::cast(nb::ndarray<nb::numpy, T, nb::ndim<1>>{values, {obstacles.size()}, owner});
  }
}

}  // namespace

nb::dict table_of(const std::vector<Obstacle>& obstacles) {
  nb::dict table;
  const Obstacle sample;
  io::visit_fields(sample, [&](const io::ObstacleField& field, const auto& value) {
    using T = std::remove_cvref_t<decltype(value)>;
    if constexpr (!std::is_same_v<T, Outline> && !std::is_same_v<T, Covariance2>) {
      table[field.name] = column_of<T>(obstacles, field.name);
    }
  });
  return table;
}

void bind_obstacles(nb::module_& module) {
  nb::class_<Obstacle> obstacle{module, "Obstacle",
                                "A tracked object or boundary. Positions in the vehicle frame; velocities relative to "
                                "the ground, in vehicle axes."};
  const Obstacle sample;
  io::visit_fields(sample, [&](const io::ObstacleField& field, const auto& value) {
    using T = std::remove_cvref_t<decltype(value)>;
    if constexpr (!std::is_same_v<T, Outline>) {
      obstacle.def_prop_ro(
          field.name, [name = field.name](const Obstacle& self) { return to_python(find<T>(self, name)); },
          nb::rv_policy::automatic);
    }
  });
  obstacle.def_prop_ro("outline", &points_of,
                       "(n, 2), m: a simple polygon of an object; an open line along the near side of a boundary.");
  obstacle.def("__repr__", [](const Obstacle& self) {
    return fmt::format("Obstacle(id={}, x_m={:.2f}, y_m={:.2f}, vx_mps={:.2f}, vy_mps={:.2f})", self.id, self.x_m,
                       self.y_m, self.vx_mps, self.vy_mps);
  });
}

}  // namespace stereogrid::python
