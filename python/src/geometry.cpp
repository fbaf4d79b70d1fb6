// SPDX-License-Identifier: Apache-2.0
#include "geometry.hpp"

#include <nanobind/operators.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/rectifier.hpp"

namespace stereogrid::python {
namespace {

constexpr const char* pose_forms{
    "(expected Pose, (x_m, y_m, yaw_rad), or world_from_camera as 3 x 4 or 4 x 4 with x right, y down, z forward)."};

Pose2 pose_of_matrix(const std::vector<double>& m) {
  const auto column{
      [&](std::size_t i, std::size_t j) { return m[i] * m[j] + m[i + 4] * m[j + 4] + m[i + 8] * m[j + 8]; }};
  constexpr double tolerance{0.01};
  for (std::size_t i{0}; i < 3; ++i) {
    for (std::size_t j{i}; j < 3; ++j) {
      if (std::abs(column(i, j) - (i == j ? 1 : 0)) <= tolerance) continue;
      throw nb::value_error(("pose: matrix without a rotation " + std::string{pose_forms}).c_str());
    }
  }
  constexpr double level{0.999};   // cosine of the angle between z before and after
  constexpr double turned{0.995};  // cosine of the angle about z
  if (m[10] > level && m[5] < turned) {
    throw nb::value_error(
        "pose: the matrix turns about its z axis, as that of a body with z up; world_from_camera turns "
        "about y. Give (x_m, y_m, yaw_rad) of the body.");
  }
  std::array<double, 12> rows{};
  std::copy_n(m.begin(), rows.size(), rows.begin());
  return ground_pose(rows);
}

template <class T>
std::pair<const char*, T> field(const char* name, T value) {
  return {name, value};
}

void bind_pose(nb::module_& module) {
  nb::class_<Pose2> pose{module, "Pose", "Position (m) and heading (rad, counter-clockwise, 0 along x) on the ground."};
  pose.def(
      "__init__",
      [](Pose2* self, double x_m, double y_m, double yaw_rad) {
        new (self) Pose2{x_m, y_m, yaw_rad};
      },
      nb::arg("x_m"), nb::arg("y_m"), nb::arg("yaw_rad"));
  pose.def(
      "__init__",
      [](Pose2* self, const std::array<double, 3>& v) {
        new (self) Pose2{v[0], v[1], v[2]};
      },
      nb::arg("x_y_yaw"));
  nb::implicitly_convertible<nb::tuple, Pose2>();
  pose.def_rw("x_m", &Pose2::x_m).def_rw("y_m", &Pose2::y_m).def_rw("yaw_rad", &Pose2::yaw_rad);
  pose.def("__mul__", [](const Pose2& a_from_b, const Pose2& b_from_c) { return a_from_b * b_from_c; });
  pose.def(
      "inverse", [](const Pose2& self) { return inverse(self); }, "Returns b_from_a of a_from_b.");
  pose.def_static(
      "from_camera", [](const std::array<double, 12>& m) { return ground_pose(m); }, nb::arg("world_from_camera"),
      "Returns the projection of a camera's pose onto the ground. world_from_camera: 3 x 4 row-major, 12 numbers.");
  pose.def(nb::self == nb::self, nb::sig("def __eq__(self, other: object, /) -> bool"));
  pose.def("__repr__", [](const Pose2& p) {
    return repr_of("Pose", field("x_m", p.x_m), field("y_m", p.y_m), field("yaw_rad", p.yaw_rad));
  });
  pose.def("__getstate__", [](const Pose2& p) { return std::array<double, 3>{p.x_m, p.y_m, p.yaw_rad}; });
  pose.def("__setstate__", [](Pose2& p, const std::array<double, 3>& v) { new (&p) Pose2{v[0], v[1], v[2]}; });
}

void bind_grid(nb::module_& module) {
  nb::class_<GridGeometry> grid{module, "GridGeometry",
                                "Places of the cells of a grid. Arrays over it have the shape (ny, nx)."};
  grid.def(
      "__init__",
      [](GridGeometry* self, double x_min_m, double y_min_m, double cell_size_m, int nx, int ny) {
        new (self) GridGeometry{x_min_m, y_min_m, cell_size_m, nx, ny};
      },
      nb::arg("x_min_m"), nb::arg("y_min_m"), nb::arg("cell_size_m"), nb::arg("nx"), nb::arg("ny"));
  grid.def_ro("x_min_m", &GridGeometry::x_min_m).def_ro("y_min_m", &GridGeometry::y_min_m);
  grid.def_ro("cell_size_m", &GridGeometry::cell_size_m);
  grid.def_ro("nx", &GridGeometry::nx).def_ro("ny", &GridGeometry::ny);
  grid.def_prop_ro(
      "shape",
      [](const GridGeometry& g) {
        return std::pair{g.ny, g.nx};
      },
      "(ny, nx).");
  grid.def_prop_ro(
      "extent",
      [](const GridGeometry& g) {
        return std::array<double, 4>{g.x_min_m, g.x_min_m + g.nx * g.cell_size_m, g.y_min_m,
                                     g.y_min_m + g.ny * g.cell_size_m};
      },
      nb::sig("def extent(self) -> list[float]"), "x_min, x_max, y_min, y_max, m.");
  grid.def(
      "center",
      [](const GridGeometry& g, int ix, int iy) {
        const Point2 middle{g.centre(ix, iy)};
        return std::pair{middle.x, middle.y};
      },
      nb::arg("ix"), nb::arg("iy"), "Returns the middle of a cell, m.");
  grid.def(
      "cell_at",
      [](const GridGeometry& g, double x_m, double y_m) -> std::optional<std::pair<int, int>> {
        const auto cell{g.cell_at({x_m, y_m})};
        return cell ? std::optional{std::pair{cell->ix, cell->iy}} : std::nullopt;
      },
      nb::arg("x_m"), nb::arg("y_m"), "Returns (ix, iy) of the cell that holds a point; None: outside.");
  grid.def(nb::self == nb::self, nb::sig("def __eq__(self, other: object, /) -> bool"));
  grid.def("__repr__", [](const GridGeometry& g) {
    return repr_of("GridGeometry", field("x_min_m", g.x_min_m), field("y_min_m", g.y_min_m),
                   field("cell_size_m", g.cell_size_m), field("nx", g.nx), field("ny", g.ny));
  });
}

/// Calls visit(name, member of Rig, docstring).
template <class Visit>
void visit_rig_fields(const Visit& visit) {
  visit("width_px", &Rig::width_px, "Width of the images.");
  visit("height_px", &Rig::height_px, "Height of the images.");
  visit("focal_px", &Rig::focal_px, "Focal length.");
  visit("cx_px", &Rig::cx_px, "Column of the principal point.");
  visit("cy_px", &Rig::cy_px, "Row of the principal point.");
  visit("baseline_m", &Rig::baseline_m, "Distance between the cameras.");
  visit("camera_height_m", &Rig::camera_height_m, "Height of the left camera's center above the ground.");
  visit("camera_pitch_rad", &Rig::camera_pitch_rad, "Positive: downwards.");
  visit("camera_roll_rad", &Rig::camera_roll_rad, "Positive: right side down.");
  visit("camera_x_m", &Rig::camera_x_m, "Position of the left camera in the vehicle frame, ahead.");
  visit("camera_y_m", &Rig::camera_y_m, "To the left.");
  visit("camera_yaw_rad", &Rig::camera_yaw_rad, "Heading of the optical axis; 0: ahead, positive: to the left.");
}

std::string repr_of_rig(const MountedRig& self) {
  std::string text{"Rig("};
  visit_rig_fields([&](const char* name, auto member, const char*) {
    text += name + std::string{"="} + nb::cast<std::string>(nb::repr(nb::cast(self.rig.*member))) + ", ";
  });
  return text + "extrinsics_given=" + (self.extrinsics_given ? "True" : "False") +
         (self.mask.empty() ? "" : ", mask=...") + (self.name.empty() ? ")" : ", name='" + self.name + "')");
}

MountedRig rig_of_file(const std::filesystem::path& path, int width_px, int height_px) {
  io::Calibration calibration{io::read_calibration(path, width_px, height_px)};
  io::fit_to_images(calibration, path.string(), width_px, height_px);
  MountedRig rig{calibration.rig, calibration.has_extrinsics};
  if (!calibration.mask.empty()) rig.mask = io::read_mask(calibration.mask, calibration);
  return rig;
}

void set_mask(MountedRig& rig, nb::handle mask) {
  rig.mask = {};
  if (!mask.is_none()) assign(rig.mask, Array{mask, "mask"}, {});
}

void bind_rig_state(nb::class_<MountedRig>& rig) {
  rig.def("__getstate__", [](const MountedRig& self) {
    nb::list values;
    visit_rig_fields([&](const char*, auto member, const char*) { values.append(self.rig.*member); });
    const Image<std::uint8_t>& m{self.mask};
    return nb::make_tuple(values, self.extrinsics_given, m.width(), m.height(),
                          nb::bytes(reinterpret_cast<const char*>(m.data()), m.size()), self.name);
  });
  rig.def("__setstate__", [](MountedRig& self, const nb::tuple& state) {
    auto* const made{new (&self) MountedRig{}};
    nb::list values{nb::borrow<nb::list>(state[0])};
    std::size_t i{0};
    visit_rig_fields([&](const char*, auto member, const char*) {
      using T = std::remove_cvref_t<decltype(made->rig.*member)>;
      made->rig.*member = nb::cast<T>(values[i++]);
    });
    made->extrinsics_given = nb::cast<bool>(state[1]);
    made->mask = {nb::cast<int>(state[2]), nb::cast<int>(state[3])};
    const nb::bytes pixels{nb::borrow<nb::bytes>(state[4])};
    std::copy_n(static_cast<const std::uint8_t*>(pixels.data()), made->mask.size(), made->mask.data());
    made->name = nb::cast<std::string>(state[5]);
  });
}

void bind_rig(nb::module_& module) {
  nb::class_<MountedRig> rig{module, "Rig",
                             "Rectified stereo pair, its extrinsics, and the mask of the vehicle itself."};
  const Rig standard;
  rig.def(
      "__init__",
      [](MountedRig* self, int width_px, int height_px, double focal_px, double cx_px, double cy_px, double baseline_m,
         double camera_height_m, double camera_pitch_rad, double camera_roll_rad, double camera_x_m, double camera_y_m,
         double camera_yaw_rad, bool extrinsics_given, nb::handle mask, std::string name) {
        new (self) MountedRig{{width_px, height_px, focal_px, cx_px, cy_px, baseline_m, camera_height_m,
                               camera_pitch_rad, camera_roll_rad, camera_x_m, camera_y_m, camera_yaw_rad},
                              extrinsics_given};
        self->name = std::move(name);
        set_mask(*self, mask);
      },
      nb::kw_only(), nb::arg("width_px"), nb::arg("height_px"), nb::arg("focal_px"), nb::arg("cx_px"), nb::arg("cy_px"),
      nb::arg("baseline_m"), nb::arg("camera_height_m") = standard.camera_height_m,
      nb::arg("camera_pitch_rad") = standard.camera_pitch_rad, nb::arg("camera_roll_rad") = standard.camera_roll_rad,
      nb::arg("camera_x_m") = standard.camera_x_m, nb::arg("camera_y_m") = standard.camera_y_m,
      nb::arg("camera_yaw_rad") = standard.camera_yaw_rad, nb::arg("extrinsics_given") = MountedRig{}.extrinsics_given,
      nb::arg("mask") = nb::none(), nb::arg("name") = "");
  visit_rig_fields([&](const char* name, auto member, const char* doc) {
    using T = std::remove_cvref_t<decltype(standard.*member)>;
    rig.def_prop_rw(
        name, [member](const MountedRig& self) { return self.rig.*member; },
        [member](MountedRig& self, T value) { self.rig.*member = value; }, doc);
  });
  rig.def_rw("extrinsics_given", &MountedRig::extrinsics_given,
             "True: height, pitch and roll were measured and are kept. False: estimated from the first frames.");
  rig.def_prop_rw(
      "mask", [](nb::handle self) { return view_unless_empty(nb::cast<const MountedRig&>(self).mask, self); },
      [](MountedRig& self, nb::handle mask) { set_mask(self, mask); }, nb::for_setter(nb::arg("mask").none()),
      "Image (height_px, width_px): 0 where the left image shows the vehicle itself; None: nowhere.");
  rig.def_rw("name", &MountedRig::name, "Name of one of several cameras: a letter, then letters, digits and _.");
  rig.def_static("from_file", &rig_of_file, nb::arg("path"), nb::arg("width_px") = 0, nb::arg("height_px") = 0,
                 "Reads a calibration file of images of that size; 0: the file has it. Raises InputError.");
  rig.def(
      "problems", [](const MountedRig& self) { return problems(self.rig); },
      "Returns what makes the rig unusable; empty: nothing.");
  rig.def("__repr__", &repr_of_rig);
  bind_rig_state(rig);
}

void bind_ground(nb::module_& module) {
  nb::class_<Ground> ground{module, "Ground", "The road as the left camera sees it in one frame."};
  ground.def_ro("height_m", &Ground::height_m, "Camera center above the road.");
  ground.def_ro("pitch_rad", &Ground::pitch_rad, "Positive: the camera is pitched downwards.");
  ground.def_ro("roll_rad", &Ground::roll_rad, "Positive: right side down.");
  ground.def_ro("estimated", &Ground::estimated, "Measured in this frame.");
  ground.def_ro("height_sigma_m", &Ground::height_sigma_m).def_ro("pitch_sigma_rad", &Ground::pitch_sigma_rad);
  ground.def_ro("roll_sigma_rad", &Ground::roll_sigma_rad);
}

}  // namespace

std::vector<MountedRig> rigs_of(const RigOrRigs& one_or_more) {
  if (const auto* one{std::get_if<MountedRig>(&one_or_more)}) return {*one};
  const auto& rigs{std::get<std::vector<MountedRig>>(one_or_more)};
  if (rigs.empty()) throw ConfigError{"rig: no rigs (expected one at least)."};
  return rigs;
}

std::vector<std::string> names_of(const std::vector<MountedRig>& rigs) {
  std::vector<std::string> names;
  const bool has_names{std::ranges::any_of(rigs, [](const MountedRig& rig) { return !rig.name.empty(); })};
  if (rigs.size() == 1 || !has_names) return names;
  for (const MountedRig& rig : rigs)
    names.push_back(rig.name.empty() ? "camera" + std::to_string(names.size()) : rig.name);
  return names;
}

std::vector<Rig> without_masks(const std::vector<MountedRig>& rigs) {
  std::vector<Rig> plain;
  for (const MountedRig& rig : rigs) plain.push_back(rig.rig);
  return plain;
}

std::optional<Pose2> pose_of(nb::handle object) {
  if (object.is_none()) return std::nullopt;
  if (nb::isinstance<Pose2>(object)) return nb::cast<Pose2>(object);
  std::vector<double> numbers;
  std::vector<std::size_t> shape;
  try {
    const nb::object array{nb::module_::import_("numpy").attr("asarray")(object, "float64")};
    shape = nb::cast<std::vector<std::size_t>>(array.attr("shape"));
    numbers = nb::cast<std::vector<double>>(array.attr("ravel")().attr("tolist")());
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError)) throw;
    throw nb::type_error((std::string{"pose: no numbers "} + pose_forms).c_str());
  }
  if (shape == std::vector<std::size_t>{3}) return Pose2{numbers[0], numbers[1], numbers[2]};
  if (shape == std::vector<std::size_t>{4, 4} || shape == std::vector<std::size_t>{3, 4})
    return pose_of_matrix(numbers);
  throw nb::value_error(("pose: " + std::to_string(numbers.size()) + " numbers " + pose_forms).c_str());
}

void bind_geometry(nb::module_& module) {
  bind_pose(module);
  bind_grid(module);
  bind_rig(module);
  bind_ground(module);
}

}  // namespace stereogrid::python
