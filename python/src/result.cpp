// SPDX-License-Identifier: Apache-2.0
#include "pipeline.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <initializer_list>
#include <map>

#include "arrays.hpp"
#include "bindings.hpp"
#include "geometry.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/run_folder/frame_lines.hpp"
#include "stereogrid/io/run_folder/run_record.hpp"
#include "stereogrid/occupancy_values.hpp"

namespace stereogrid::python {
namespace {

void bind_stages(nb::module_& module) {
  nb::class_<StageImages> stages{module, "StageImages",
                                 "Images between the stages. H, W: image size; D: disparities; views."};
  bind_image(stages, "obstacle_disparity", &StageImages::obstacle_disparity, "(H, W) px, 0 = none.");
  bind_image(stages, "road_disparity", &StageImages::road_disparity, "(H, W) px, 0 = none.");
  bind_image(stages, "match_confidence", &StageImages::match_confidence,
             "(H, W) probability that the disparity is right to a pixel, 0 = none.");
  bind_image(stages, "ambiguous", &StageImages::ambiguous,
             "(H, W) 1: a textured obstacle pixel whose match is not unique, else 0.");
  stages.def_prop_ro(
      "possible",
      [](nb::handle self) {
        const auto& possible{nb::cast<const StageImages&>(self).possible};
        return nb::ndarray<nb::numpy, const int, nb::ndim<1>>{possible.data(), {possible.size()}, self};
      },
      "(D) N_P, eq. 10.");
  bind_image(stages, "visible", &StageImages::visible, "(D, W) N_V, eq. 11.");
  bind_image(stages, "observed_pixels", &StageImages::observed, "(D, W) N_O.");
  bind_image(stages, "visibility", &StageImages::visibility, "(D, W) P(V), eq. 11.");
  bind_image(stages, "obstacle_confidence", &StageImages::obstacle_confidence, "(D, W) P(C), eq. 13.");
  bind_image(stages, "road_confidence", &StageImages::road_confidence, "(D, W) P(R), eq. 15.");
  bind_image(stages, "u_occupancy", &StageImages::occupancy, "(D, W) P(T), eq. 14.");
  bind_image(stages, "u_occupancy_smooth", &StageImages::occupancy_smooth, "(D, W) after the Gaussian.");
}

/// Copies several images of one size into one array (n, ny, nx).
Planes<float> stack(std::initializer_list<const Image<float>*> layers) {
  const Image<float>& first{**layers.begin()};
  auto* const values{new std::vector<float>};
  const nb::capsule owner{values, [](void* p) noexcept { delete static_cast<std::vector<float>*>(p); }};
  values->reserve(layers.size() * first.size());
  for (const Image<float>* layer : layers) values->insert(values->end(), layer->begin(), layer->end());
  return {values->data(),
          {layers.size(), static_cast<std::size_t>(first.height()), static_cast<std::size_t>(first.width())},
          owner};
}

const FrameResult& data_of(nb::handle self) {
  return nb::cast<const Result&>(self).data;
}

constexpr auto of_result = [](const Result& result) -> const FrameResult& { return result.data; };

const char* const occupancy_text{"P(occupied) in [0, 1]; 0.5 = unknown. View (ny, nx)."};
const char* const velocity_text{"x and y, m/s over ground, along the axes of the grid. Copy (2, ny, nx)."};
const char* const covariance_text{"xx, xy and yy of the velocity, m²/s². Copy (3, ny, nx)."};
const char* const age_text{"Time since the cell was last observed, s; inf = never. View (ny, nx)."};
const char* const moving_text{"P(occupied by a dynamic object). View (ny, nx)."};

/// Layers of the filtered grid, which `of` finds in the bound object.
template <class Bound, class Of = std::identity>
void bind_layers(nb::class_<Bound>& bound, Of of = {}) {
  bind_image(bound, "occupancy", &GridLayers::occupancy, occupancy_text, of);
  bound.def_prop_ro(
      "velocity",
      [=](nb::handle self) {
        const GridLayers& layers{of(nb::cast<const Bound&>(self))};
        return stack({&layers.velocity_x, &layers.velocity_y});
      },
      nb::rv_policy::automatic, velocity_text);
  bound.def_prop_ro(
      "velocity_covariance",
      [=](nb::handle self) {
        const GridLayers& layers{of(nb::cast<const Bound&>(self))};
        return stack({&layers.velocity_xx, &layers.velocity_xy, &layers.velocity_yy});
      },
      nb::rv_policy::automatic, covariance_text);
  bind_image(bound, "age_s", &GridLayers::age_s, age_text, of);
  bind_image(bound, "moving", &GridLayers::moving, moving_text, of);
}

void bind_world(nb::module_& module) {
  nb::class_<GridLayers> layers{module, "GridLayers", "The filtered grid in one frame of reference."};
  layers.def_ro("grid", &GridLayers::geometry);
  bind_layers(layers);
  nb::class_<Prediction> prediction{module, "Prediction", "The filtered grid some time later."};
  prediction.def_ro("horizon_s", &Prediction::horizon_s);
  bind_image(prediction, "occupancy", &Prediction::occupancy, "In the cells of FrameResult.grid.");
  bind_image(prediction, "world_occupancy", &Prediction::world_occupancy, "In the cells of FrameResult.world.grid.");
}

template <class Byte>
std::optional<Plane<std::uint8_t>> bytes_of(const Image<Byte>& image, nb::handle owner) {
  static_assert(sizeof(Byte) == 1);
  if (image.empty()) return std::nullopt;
  return Plane<std::uint8_t>{reinterpret_cast<const std::uint8_t*>(image.data()),
                             {static_cast<std::size_t>(image.height()), static_cast<std::size_t>(image.width())},
                             owner};
}

void bind_grids(nb::class_<Result>& result) {
  bind_image(result, "observed", &FrameResult::observed,
             "P(occupied) of this frame alone; 0.5 = unknown. View (ny, nx).", of_result);
  bind_layers(result, [](const Result& self) -> const GridLayers& { return self.data.vehicle; });
  bind_image_or_none(result, "elevation_m", &FrameResult::elevation_m,
                     "Above the ground plane; NaN = unseen. View (ny, nx); None: ground.model is plane.", of_result);
  bind_image_or_none(result, "elevation_sigma_m", &FrameResult::elevation_sigma_m,
                     "Standard deviation of the elevation; NaN = unseen.", of_result);
  result.def_prop_ro(
      "terrain", [](nb::handle self) { return bytes_of(data_of(self).terrain, self); },
      "Class of the ground, numbers of TERRAIN_CLASSES. View (ny, nx); None: ground.model is plane.");
  result.def_prop_ro(
      "witness", [](nb::handle self) { return bytes_of(data_of(self).witness, self); },
      "Evidence of free cells: & 15 is a number of WITNESSES, >> 4 the class k of its age, up to 2**k / 16 s; 0: this "
      "frame. View (ny, nx); None: ground.model is plane.");
  bind_image_or_none(result, "world_elevation_m", &FrameResult::world_elevation_m,
                     "Above the ground plane over all frames, in the cells of `world`; NaN = never seen. None: "
                     "ground.model is plane.",
                     of_result);
  bind_image_or_none(result, "world_elevation_sigma_m", &FrameResult::world_elevation_sigma_m,
                     "Standard deviation of that elevation; NaN = never seen.", of_result);
  result.def_prop_ro(
      "world_terrain", [](nb::handle self) { return bytes_of(data_of(self).world_terrain, self); },
      "Class of the ground over time, in the cells of `world`: drops and obstacles of all frames, free ground. None: "
      "ground.model is plane.");
  result.def_prop_ro(
      "world", [](const Result& self) -> const GridLayers& { return self.data.world; },
      nb::rv_policy::reference_internal, "The filtered grid in the world frame; its origin moves in whole cells.");
  result.def_prop_ro(
      "predictions",
      [](nb::handle self) {
        nb::list views;
        for (const Prediction& p : data_of(self).predictions) {
          views.append(nb::cast(&p, nb::rv_policy::reference_internal, self));
        }
        return views;
      },
      nb::sig("def predictions(self) -> list[Prediction]"), "One for each of the horizons of the pipeline.");
  result.def_prop_ro(
      "stages", [](const Result& self) -> const StageImages& { return self.data.stages; },
      nb::rv_policy::reference_internal, "Images between the stages; empty arrays: Pipeline(stages=False).");
}

/// Cells as ROS has them.
nb::ndarray<nb::numpy, std::int8_t, nb::ndim<2>> occupancy_values_of(
    nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu> occupancy, const std::string& scale) {
  const auto& names{names_of(OccupancyScale{})};
  const auto found{std::ranges::find(names, scale)};
  if (found == names.end()) {
    throw ConfigError{fmt::format("scale '{}' (allowed: {}).", scale, fmt::join(names, ", "))};
  }
  const View<const float> cells{occupancy.data(), static_cast<int>(occupancy.shape(1)),
                                static_cast<int>(occupancy.shape(0)), static_cast<std::ptrdiff_t>(occupancy.shape(1))};
  auto* const values{
      new std::vector<std::int8_t>{occupancy_values(cells, static_cast<OccupancyScale>(found - names.begin()))}};
  const nb::capsule owner{values, [](void* p) noexcept { delete static_cast<std::vector<std::int8_t>*>(p); }};
  return {values->data(), {occupancy.shape(0), occupancy.shape(1)}, owner};
}

std::map<std::string, double> times_of(const Result& self) {
  std::map<std::string, double> times;
  for (const io::StageField& field : io::stage_fields)
    times.emplace(field.name, self.data.timing_ms.*field.milliseconds);
  return times;
}

std::vector<std::string> texts_of(const std::vector<Warning>& warnings) {
  std::vector<std::string> texts;
  for (const Warning& warning : warnings) texts.push_back(warning.text);
  return texts;
}

void bind_cameras(nb::module_& module, nb::class_<Result>& result) {
  nb::class_<FrameResult> camera{module, "CameraResult",
                                 "Result of one of several cameras alone. Views in the cells of FrameResult.grid."};
  camera.def_ro("name", &FrameResult::camera_name, "Name of the camera (Rig.name).");
  camera.def_ro("speed_limit_mps", &FrameResult::speed_limit_mps,
                "Limit of this camera; 0 without a usable frame; inf: none.");
  camera.def_ro("has_images", &FrameResult::has_images, "False: the camera has no images in this frame.");
  camera.def_prop_ro(
      "rig", [](const FrameResult& self) { return MountedRig{self.rig}; }, "Rig of this frame.");
  camera.def_ro("ground", &FrameResult::ground);
  camera.def_ro("obstacle_density", &FrameResult::obstacle_density, "Share of the pixels.");
  camera.def_ro("road_density", &FrameResult::road_density, "Share of the pixels.");
  bind_image(camera, "observed", &FrameResult::observed, occupancy_text);
  bind_image_or_none(camera, "elevation_m", &FrameResult::elevation_m,
                     "Above the ground plane; NaN = unseen. None: ground.model is plane.");
  camera.def_prop_ro(
      "terrain", [](nb::handle self) { return bytes_of(nb::cast<const FrameResult&>(self).terrain, self); },
      "Class of the ground, numbers of TERRAIN_CLASSES. None: ground.model is plane.");
  camera.def_ro("stages", &FrameResult::stages,
                "Images between the stages; those of the first camera are FrameResult.stages.");
  camera.def_ro("status", &FrameResult::status);
  camera.def_prop_ro("warnings", [](const FrameResult& self) { return texts_of(self.warnings); });
  camera.def("__repr__", [](const FrameResult& self) {
    return repr_of("CameraResult", std::pair{"name", self.camera_name}, std::pair{"has_images", self.has_images},
                   std::pair{"obstacle_density", self.obstacle_density});
  });
  result.def_prop_ro(
      "cameras",
      [](nb::handle self) {
        nb::list views;
        for (const FrameResult& one : data_of(self).cameras)
          views.append(nb::cast(&one, nb::rv_policy::reference_internal, self));
        return views;
      },
      nb::sig("def cameras(self) -> list[CameraResult]"), "One for each of several Pipeline.rigs; one camera: empty.");
}

void bind_facts(nb::class_<Result>& result) {
  result.def_ro("name", &Result::name).def_ro("index", &Result::index).def_ro("stamp_ns", &Result::stamp_ns);
  result.def_prop_ro(
      "grid", [](const Result& self) { return self.data.vehicle.geometry; }, "Cells of the vehicle-frame arrays.");
  result.def_prop_ro(
      "pose", [](const Result& self) { return self.data.world_from_vehicle; }, "world_from_vehicle.");
  result.def_prop_ro(
      "rig", [](const Result& self) { return MountedRig{self.data.rig}; }, "Rig of this frame.");
  result.def_prop_ro(
      "level_rig", [](const Result& self) { return MountedRig{self.data.level_rig}; }, "Rig of the stages' images.");
  result.def_prop_ro("ground", [](const Result& self) { return self.data.ground; });
  result.def_prop_ro(
      "obstacles", [](const Result& self) { return self.data.obstacles; }, "Tracked obstacles, copies.");
  result.def(
      "obstacles_table", [](const Result& self) { return table_of(self.data.obstacles); },
      "Returns the fields of the obstacles as arrays of shape (n,), such as pandas.DataFrame takes; `kind` is a list. "
      "Outlines and covariances are left out.");
  result.def_prop_ro(
      "obstacle_density", [](const Result& self) { return self.data.obstacle_density; }, "Share of the pixels.");
  result.def_prop_ro(
      "road_density", [](const Result& self) { return self.data.road_density; }, "Share of the pixels.");
  result.def_prop_ro(
      "speed_limit_mps", [](const Result& self) { return self.data.speed_limit_mps; },
      "A faster vehicle cannot stop within the range of hazards; inf: ground.model is plane.");
  result.def_prop_ro(
      "speed_limit_reason",
      [](const Result& self) {
        return names_of(SpeedReason{})[static_cast<std::size_t>(self.data.speed_limit_reason)];
      },
      "\"none\", \"noise\", \"ditches\", \"drops\", \"descents\" or \"frame\".");
  result.def_prop_ro("timing_ms", &times_of, "Wall-clock times of the stages.");
  result.def_prop_ro(
      "status", [](const Result& self) { return self.data.status; }, "Flags to check before relying on the grids.");
  result.def_prop_ro("warnings", [](const Result& self) { return texts_of(self.data.warnings); });
  result.def(
      "save",
      [](const Result& self, const std::filesystem::path& path, const std::vector<std::string>& layers) {
        io::write_grids(path, self.data, layers);
      },
      nb::arg("path"), nb::arg("layers") = std::vector<std::string>{}, nb::call_guard<ReleasedGil>(),
      "Writes the grids as stereogrid run does (.npz). layers: some of its arrays; empty: all. Raises DeviceError.");
  result.def("__repr__", [](const Result& self) {
    return repr_of("FrameResult", std::pair{"name", self.name}, std::pair{"stamp_ns", self.stamp_ns},
                   std::pair{"obstacles", self.data.obstacles.size()});
  });
}

}  // namespace

std::unique_ptr<FrameResult> ResultPool::take() {
  const std::lock_guard lock{mutex_};
  if (free_.empty()) return std::make_unique<FrameResult>();
  std::unique_ptr<FrameResult> result{std::move(free_.back())};
  free_.pop_back();
  return result;
}

void ResultPool::give_back(std::unique_ptr<FrameResult> result) noexcept {
  const std::lock_guard lock{mutex_};
  if (free_.capacity() < capacity_) free_.reserve(capacity_);
  if (free_.size() < capacity_) free_.push_back(std::move(result));
}

void bind_result(nb::module_& module) {
  nb::enum_<FrameStatus> status{module, "FrameStatus", "Conditions that limit the use of a frame's grids."};
  for (std::size_t i{0}; i < names_of(FrameStatus{}).size(); ++i) {
    status.value(names_of(FrameStatus{})[i].data(), static_cast<FrameStatus>(i));
  }
  const auto names = [](const auto& all) {
    nb::list list;
    for (const std::string_view name : all) list.append(nb::cast(name));
    return nb::tuple(list);
  };
  module.attr("TERRAIN_CLASSES") = names(names_of(TerrainClass{}));
  module.attr("WITNESSES") = names(names_of(Witness{}));
  module.def(
      "occupancy_values", &occupancy_values_of, nb::arg("occupancy"), nb::arg("scale") = "percent",
      "Returns the int8 cells of nav_msgs/OccupancyGrid. scale: \"percent\", \"trinary\", \"nav2\" (Nav2's static "
      "layer) or \"autoware\". Raises ConfigError.");
  bind_world(module);
  bind_stages(module);
  nb::class_<Result> result{module, "FrameResult",
                            "Result of a frame. Arrays are read-only; views keep the result alive and never change."};
  bind_grids(result);
  bind_cameras(module, result);
  bind_facts(result);
}

}  // namespace stereogrid::python
