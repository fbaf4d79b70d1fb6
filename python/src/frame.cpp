// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "geometry.hpp"
#include "recording.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::python {
namespace {

using nb::handle;

void bind_truth_images(nb::class_<FrameTruth>& truth) {
  bind_image_or_none(truth, "disparity", &FrameTruth::disparity, "px, 0 = none.");
  bind_image_or_none(truth, "label", &FrameTruth::label, "0 sky, 1 road, 2 obstacle, 3 low.");
  bind_image_or_none(truth, "instance", &FrameTruth::instance, "Id of the object, 0 = none.");
  bind_image_or_none(truth, "seen_by_both", &FrameTruth::seen_by_both, "255: visible in the right image, too.");
  bind_image_or_none(truth, "state", &FrameTruth::state, "State of the cells: 0 hidden, 1 seen free, 2 seen occupied.");
  bind_image_or_none(truth, "occupied", &FrameTruth::occupied, "A footprint overlaps the cell, seen or not.");
  bind_image_or_none(truth, "owner", &FrameTruth::owner, "Id of the object on the cell, 0 = none.");
  bind_image_or_none(truth, "pixels", &FrameTruth::pixels, "Obstacle pixels that fall into the cell.");
  bind_image_or_none(truth, "seen_object", &FrameTruth::seen_object, "Id of the object of most of those pixels.");
  bind_image_or_none(truth, "free_points", &FrameTruth::free_points, "Seen ones of the cell's 3 x 3 ground points.");
  bind_image_or_none(truth, "low", &FrameTruth::low, "A low object lies on the cell.");
  bind_image_or_none(truth, "velocity_x", &FrameTruth::velocity_x, "m/s, world axes.");
  bind_image_or_none(truth, "velocity_y", &FrameTruth::velocity_y, "m/s, world axes.");
  bind_image_or_none(truth, "terrain", &FrameTruth::terrain, "0 hidden, 1 drivable, 2 obstacle, 3 drop, 4 beyond.");
  bind_image_or_none(truth, "elevation_m", &FrameTruth::elevation_m, "Height of the ground at the cell's center.");
  bind_image_or_none(truth, "step_m", &FrameTruth::step_m, "Height of a step; negative where it falls.");
}

nb::ndarray<nb::numpy, const double, nb::shape<-1, 2>> footprint_of(handle self) {
  const auto& points{nb::cast<const TruthObject&>(self).footprint};
  return {reinterpret_cast<const double*>(points.data()), {points.size(), 2}, self};
}

void bind_truth(nb::module_& module) {
  nb::class_<TruthObject> object{module, "TruthObject", "An object of a scene."};
  object.def_ro("id", &TruthObject::id).def_ro("kind", &TruthObject::kind);
  object.def_ro("pose", &TruthObject::world_from_object, "world_from_object.");
  object.def_ro("vx_mps", &TruthObject::vx_mps, "World axes.").def_ro("vy_mps", &TruthObject::vy_mps);
  object.def_ro("height_m", &TruthObject::height_m);
  object.def_ro("pixels", &TruthObject::pixels, "Seen in the left image.");
  object.def_prop_ro("footprint", &footprint_of, "(n, 2), m, world frame; convex.");
  nb::class_<TruthEgo> ego{module, "TruthEgo", "Motion of the vehicle in the world frame."};
  ego.def_ro("pose", &TruthEgo::world_from_vehicle).def_ro("vx_mps", &TruthEgo::vx_mps);
  ego.def_ro("vy_mps", &TruthEgo::vy_mps).def_ro("yaw_rate_radps", &TruthEgo::yaw_rate_radps);
  nb::class_<TruthGrid> grid{module, "TruthGrid", "Cells that the truth is given on."};
  grid.def_ro("grid", &TruthGrid::geometry).def_ro("height_min_m", &TruthGrid::height_min_m);
  grid.def_ro("height_max_m", &TruthGrid::height_max_m);
  nb::class_<FrameTruth> truth{module, "FrameTruth",
                               "Exact truth of a frame; views. None: the scene has no such layer."};
  truth.def_ro("name", &FrameTruth::name).def_ro("stamp_ns", &FrameTruth::stamp_ns);
  truth.def_ro("ego", &FrameTruth::ego).def_ro("objects", &FrameTruth::objects);
  bind_truth_images(truth);
}

std::unique_ptr<FrameTruth> truth_of(const Frame& frame) {
  if (!frame.recording) throw InputError{"The frame is not one of a recording and has no truth."};
  const ReleasedGil release;
  return std::make_unique<FrameTruth>(frame.recording->truth(static_cast<std::size_t>(frame.data.index)));
}

using Cells = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

Image<float> copy_of(const Cells& cells) {
  Image<float> image{static_cast<int>(cells.shape(1)), static_cast<int>(cells.shape(0))};
  std::copy_n(cells.data(), image.size(), image.data());
  return image;
}

void bind_observed_grid(nb::module_& module) {
  nb::class_<ObservedGrid> grid{module, "ObservedGrid", "Grid of another source at a frame's time, to be fused."};
  grid.def(
      "__init__",
      [](ObservedGrid* self, const GridGeometry& geometry, const Cells& occupancy,
         const std::optional<Cells>& confidence) {
        new (self) ObservedGrid{geometry, copy_of(occupancy), confidence ? copy_of(*confidence) : Image<float>{}};
      },
      nb::arg("grid"), nb::arg("occupancy"), nb::arg("confidence") = nb::none(),
      "grid: in the vehicle frame. occupancy: (ny, nx), P(occupied), 0.5 = unknown. confidence: of each cell, in [0, "
      "1]; "
      "left out: 1.");
  grid.def_ro("grid", &ObservedGrid::geometry);
  grid.def_prop_ro("occupancy",
                   [](handle self) { return view_of(nb::cast<const ObservedGrid&>(self).occupancy, self); });
  grid.def_prop_ro("confidence",
                   [](handle self) { return view_unless_empty(nb::cast<const ObservedGrid&>(self).confidence, self); });
}

void construct(Frame* self, const ImageArguments& images, const std::optional<MountedRig>& rig,
               std::optional<std::int64_t> stamp_ns, const std::optional<Pose2>& pose, std::optional<std::string> name,
               std::int64_t index, int camera) {
  if (!images.depth.is_none() && !rig) {
    throw nb::type_error("Frame: depth without rig. Give the rig, for its focal length and baseline.");
  }
  if (index < 0) throw nb::value_error(fmt::format("index: {} (allowed from 0).", index).c_str());
  const ImageArrays arrays{images};
  Frame frame;
  arrays.copy_to(frame.data, rig ? rig->rig : Rig{});
  frame.data.name = name ? std::move(*name) : numbered_name(index);
  frame.data.index = index;
  frame.data.stamp_ns = stamp_ns.value_or(index * assumed_step_ns);
  frame.data.world_from_vehicle = pose;
  frame.data.camera = camera;
  new (self) Frame{std::move(frame)};
}

void bind_constructor(nb::class_<Frame>& frame) {
  frame.def(
      "__init__",
      [](Frame* self, nb::handle left, nb::handle right, std::optional<std::int64_t> stamp_ns, nb::handle pose,
         nb::handle disparity, nb::handle depth, std::optional<double> depth_scale,
         const std::optional<MountedRig>& rig, std::optional<std::string> name, std::int64_t index,
         const std::string& color, std::optional<int> bits, int camera) {
        PixelOptions pixels{color};
        pixels.bits = bits.value_or(pixels.bits);
        construct(self, {left, right, disparity, depth, depth_scale, pixels}, rig, stamp_ns, pose_of(pose),
                  std::move(name), index, camera);
      },
      nb::arg("left"), nb::arg("right") = nb::none(), nb::arg("stamp_ns") = nb::none(), nb::arg("pose") = nb::none(),
      nb::kw_only(), nb::arg("disparity") = nb::none(), nb::arg("depth") = nb::none(),
      nb::arg("depth_scale") = nb::none(), nb::arg("rig") = nb::none(), nb::arg("name") = nb::none(),
      nb::arg("index") = 0, nb::arg("color") = "", nb::arg("bits") = nb::none(), nb::arg("camera") = 0,
      nb::sig("def __init__(self, left: ArrayLike, right: ArrayLike | None = None, stamp_ns: int | None = None, pose: "
              "Pose | ArrayLike | None = None, *, disparity: ArrayLike | None = None, depth: "
              "ArrayLike | None = None, depth_scale: float | None = None, rig: Rig | None = None, name: str | None = "
              "None, index: int = 0, color: str = '', bits: int | None = None, camera: int = 0) -> None"),
      "Copies images as Pipeline.process() takes them. rig: required with depth. Left out: stamp_ns is index times 0.1 "
      "s, name is the index. camera: index into Pipeline.rigs. Raises TypeError, ValueError.");
}

std::vector<Frame> others_of(const Frame& frame) {
  std::vector<Frame> others;
  for (const StereoFrame& other : frame.data.others) others.push_back({other});
  return others;
}

void bind_other_cameras(nb::class_<Frame>& frame) {
  frame.def_prop_ro(
      "camera", [](const Frame& self) { return self.data.camera; }, "Index into Pipeline.rigs.");
  frame.def_prop_rw(
      "others", &others_of, [](Frame& self, const std::vector<const Frame*>& others) { set_others(self.data, others); },
      "Frames of other cameras, about the same time; copies.");
}

void bind_other_grids(nb::class_<Frame>& frame) {
  frame.def_prop_rw(
      "other_grids", [](const Frame& self) { return self.data.other_grids; },
      [](Frame& self, std::vector<ObservedGrid> grids) { self.data.other_grids = std::move(grids); },
      "Grids of other sources, fused with the frame's own; a copy.");
}

}  // namespace

void bind_frame(nb::module_& module) {
  bind_truth(module);
  bind_observed_grid(module);
  nb::class_<Frame> frame{module, "Frame", "A rectified frame. Images are read-only views."};
  bind_constructor(frame);
  frame.def_prop_ro(
      "left", [](handle self) { return view_of(nb::cast<const Frame&>(self).data.left, self); },
      "Grey levels (height, width), uint8.");
  frame.def_prop_ro(
      "right", [](handle self) { return view_unless_empty(nb::cast<const Frame&>(self).data.right, self); },
      "As left; None: the frame has disparities.");
  frame.def_prop_ro(
      "disparity", [](handle self) { return view_unless_empty(nb::cast<const Frame&>(self).data.disparity, self); },
      "(height, width) px, 0 = none; None: the frame has a right image.");
  frame.def_prop_ro(
      "labels", [](handle self) { return view_unless_empty(nb::cast<const Frame&>(self).data.labels, self); },
      "(height, width) uint8: 0 none, 1 ignore, 2 passable, 3 obstacle, 4 mover; None: there are none.");
  frame.def_prop_ro("name", [](const Frame& self) { return self.data.name; });
  frame.def_prop_ro(
      "index", [](const Frame& self) { return self.data.index; }, "Place in the recording, from 0.");
  frame.def_prop_ro(
      "stamp_ns", [](const Frame& self) { return self.data.stamp_ns; }, "Instant of exposure.");
  frame.def_prop_rw(
      "pose", [](const Frame& self) { return self.data.world_from_vehicle; },
      [](Frame& self, nb::handle pose) { self.data.world_from_vehicle = pose_of(pose); },
      nb::for_setter(nb::arg("pose").none()), "world_from_vehicle; None: unknown.");
  frame.def_prop_ro(
      "warning", [](const Frame& self) { return self.warning.value_or(""); },
      "Warning of the odometry, added to the result's; \"\": none.");
  bind_other_cameras(frame);
  bind_other_grids(frame);
  frame.def_prop_ro("truth", &truth_of,
                    "Exact truth of a scene or a rendered drive. Raises InputError: there is none.");
  frame.def("__repr__", [](const Frame& self) {
    return repr_of("Frame", std::pair{"name", self.data.name}, std::pair{"stamp_ns", self.data.stamp_ns});
  });
}

}  // namespace stereogrid::python
