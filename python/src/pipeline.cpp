// SPDX-License-Identifier: Apache-2.0
#include "pipeline.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <optional>
#include <span>
#include <type_traits>

#include "bindings.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::python {
namespace {

constexpr std::size_t grid_layers{8};  ///< layers of DeviceGrids::vehicle and world

}  // namespace

PyPipeline::Busy::Busy(PyPipeline& pipeline) : flag_{pipeline.busy_} {
  if (!flag_.test_and_set()) return;
  PyErr_SetString(PyExc_RuntimeError,
                  "The pipeline is in use by another thread (allowed: one call at a time). Construct a pipeline for "
                  "each thread.");
  throw nb::python_error();
}

PipelineOptions PyPipeline::with(PipelineOptions options, const std::vector<MountedRig>& rigs,
                                 const app::DeviceOptions& device) {
  const std::string problem{app::device_problem(device.device)};
  if (!problem.empty()) throw ConfigError{"device " + problem + "."};
  app::set_device(options, device);
  options.mask = rigs.front().mask;
  for (std::size_t i{1}; i < rigs.size(); ++i) options.other_masks.push_back(rigs[i].mask);
  options.camera_names = names_of(rigs);
  options.extrinsics_given = std::ranges::all_of(rigs, &MountedRig::extrinsics_given);
  return options;
}

ResultObject PyPipeline::process(const Frame& frame) {
  const Busy busy{*this};
  ResultObject result{new_result()};
  auto& of_frame{nb::cast<Result&>(result)};
  {
    const ReleasedGil release;
    run(frame, frame.data, of_frame);
  }
  warn_once(of_frame.data);
  return result;
}

ResultObject PyPipeline::process(const std::vector<const Frame*>& frames) {
  if (frames.empty()) throw InputError{"process(): no frames (expected one at least, at most one of a camera)."};
  if (std::ranges::find(frames, nullptr) != frames.end())
    throw nb::type_error("process(): None in the list (expected frames; leave out a camera without one).");
  Frame all{*frames.front()};
  set_others(all.data, frames);
  all.data.others.erase(all.data.others.begin());
  return process(all);
}

void PyPipeline::warn_once(const FrameResult& result) {
  for (const Warning& warning : result.warnings) {
    if (warning.status == FrameStatus::pose_missing) continue;  // usual without poses
    if (!warned_.insert(app::without_digits(warning.text)).second) continue;
    if (PyErr_WarnEx(PyExc_RuntimeWarning, warning.text.c_str(), 1) != 0) throw nb::python_error();
  }
}

template <class Images>
void PyPipeline::run(const Frame& frame, const Images& images, Result& result) {
  if constexpr (std::is_same_v<Images, DeviceImages>) {
    pipeline_.process_from_device(frame.data, images, result.data);
  } else {
    pipeline_.process(frame.data, images, result.data);
  }
  if (frame.odometry_ms) result.data.timing_ms.odometry = *frame.odometry_ms;
  if (frame.warning) result.data.warnings.push_back({*frame.warning});
  result.name = frame.data.name;
  result.index = frame.data.index;
  result.stamp_ns = frame.data.stamp_ns;
  next_stamp_ns_ = frame.data.stamp_ns + assumed_step_ns;
  next_index_ = frame.data.index + 1;
}

ResultObject PyPipeline::process(ArrayFrame arrays) {
  const Busy busy{*this};
  std::optional<ImageArrays> readers;
  std::optional<DeviceArrays> on_device;
  if (DeviceArrays::has_any(arrays.images)) {
    on_device.emplace(arrays.images);
  } else {
    readers.emplace(arrays.images);
  }
  ResultObject result{new_result()};
  auto& of_frame{nb::cast<Result&>(result)};
  {
    const ReleasedGil release;
    StereoFrame& frame{frame_.data};
    frame.stamp_ns = arrays.stamp_ns.value_or(next_stamp_ns_);
    frame.index = next_index_;
    frame.name = numbered_name(next_index_);
    frame.world_from_vehicle = arrays.pose;
    frame.other_grids = std::move(arrays.other_grids);
    if (on_device) {
      run(frame_, on_device->images(), of_frame);
    } else {
      run(frame_, readers->view(frame, pipeline_.rig()), of_frame);
    }
  }
  warn_once(of_frame.data);
  return result;
}

PyDeviceGrids PyPipeline::device_grids() {
  const DeviceGrids grids{exclusively([](Pipeline& pipeline) { return pipeline.device_grids(); })};
  const auto layers = [this](const float* data, const GridGeometry& grid, std::size_t count) {
    DeviceLayers found{data, {static_cast<std::size_t>(grid.ny), static_cast<std::size_t>(grid.nx)}, gpu_};
    if (count > 0) found.shape.insert(found.shape.begin(), count);
    return found;
  };
  return {layers(grids.observed, pipeline_.vehicle_grid(), 0),
          layers(grids.vehicle, pipeline_.vehicle_grid(), grid_layers),
          layers(grids.world, pipeline_.world_grid(), grid_layers)};
}

namespace {

void bind_device_grids(nb::module_& module, nb::class_<PyPipeline>& pipeline) {
  nb::class_<DeviceLayers> layers{
      module, "DeviceLayers",
      "float32 array in the memory of a pipeline's GPU, for torch.from_dlpack(), cupy.from_dlpack() and others. The "
      "pipeline's next call overwrites it: copy it, and wait for the copy."};
  layers.def_prop_ro("shape", [](const DeviceLayers& self) { return nb::tuple(nb::cast(self.shape)); });
  layers.def_prop_ro("__cuda_array_interface__", [](const DeviceLayers& self) {
    nb::dict array;
    array["shape"] = nb::tuple(nb::cast(self.shape));
    array["typestr"] = "<f4";
    array["data"] = nb::make_tuple(reinterpret_cast<std::uintptr_t>(self.data), false);
    array["strides"] = array["stream"] = nb::none();
    array["version"] = 3;
    return array;
  });
  layers.def("__dlpack_device__",
             [](const DeviceLayers& self) { return nb::make_tuple(int{nb::device::cuda::value}, self.device); });
  layers.def(
      "__dlpack__",
      [](nb::handle self, const nb::kwargs&) {
        const auto& array{nb::cast<const DeviceLayers&>(self)};
        return nb::cast(nb::ndarray<float, nb::device::cuda>{const_cast<float*>(array.data), array.shape.size(),
                                                             array.shape.data(), self, nullptr, nb::dtype<float>(),
                                                             nb::device::cuda::value, array.device});
      },
      nb::sig("def __dlpack__(self, **kwargs: Any) -> Any"));
  nb::class_<PyDeviceGrids> grids{module, "DeviceGrids", "Grids of the last frame in the memory of a pipeline's GPU."};
  grids.def_ro("observed", &PyDeviceGrids::observed, "(ny, nx), as FrameResult.observed.");
  grids.def_ro("vehicle", &PyDeviceGrids::vehicle,
               "(8, ny, nx): occupancy, velocity x and y, age, velocity covariance xx, xy and yy, moving.");
  grids.def_ro("world", &PyDeviceGrids::world, "Likewise, in the cells of FrameResult.world.");
  pipeline.def("device_grids", &PyPipeline::device_grids, nb::keep_alive<0, 1>(),
               "The grids of the last frame where the GPU has left them. Raises ConfigError: there is none; "
               "InputError: no frame.");
}

void construct(PyPipeline* self, const Config& config, const RigOrRigs& rig, const std::optional<std::string>& device,
               std::optional<int> threads, std::optional<bool> stages, const std::vector<double>& horizons_s,
               const std::optional<Pose2>& start, bool in_world_of_poses) {
  app::DeviceOptions where;
  where.device = device.value_or(where.device);
  where.threads = threads.value_or(where.threads);
  PipelineOptions options;
  options.stages = stages.value_or(options.stages);
  options.horizons_s = horizons_s;
  options.start = start.value_or(options.start);
  options.in_world_of_poses = in_world_of_poses;
  const std::vector<MountedRig> rigs{rigs_of(rig)};
  const ReleasedGil release;
  new (self) PyPipeline{config, rigs, where, std::move(options)};
}

void bind_process(nb::class_<PyPipeline>& pipeline) {
  pipeline.def(
      "process", [](PyPipeline& self, const Frame& frame) { return self.process(frame); }, nb::arg("frame"),
      "Processes the next frame. Releases the GIL. Raises InputError, DeviceError; RuntimeError: in use by another "
      "thread.");
  pipeline.def(
      "process", [](PyPipeline& self, const std::vector<const Frame*>& frames) { return self.process(frames); },
      nb::arg("frames"), "Processes frames of several cameras, about the same time; the first one names the result.");
  pipeline.def(
      "process",
      [](PyPipeline& self, nb::handle left, nb::handle right, nb::handle disparity, nb::handle depth,
         std::optional<double> depth_scale, std::optional<std::int64_t> stamp_ns, nb::handle pose,
         std::vector<ObservedGrid> other_grids, const std::string& color, std::optional<int> bits) {
        PixelOptions pixels{color};
        pixels.bits = bits.value_or(pixels.bits);
        return self.process(ArrayFrame{
            {left, right, disparity, depth, depth_scale, pixels}, stamp_ns, pose_of(pose), std::move(other_grids)});
      },
      nb::arg("left"), nb::arg("right") = nb::none(), nb::kw_only(), nb::arg("disparity") = nb::none(),
      nb::arg("depth") = nb::none(), nb::arg("depth_scale") = nb::none(), nb::arg("stamp_ns") = nb::none(),
      nb::arg("pose") = nb::none(), nb::arg("other_grids") = std::vector<ObservedGrid>{}, nb::arg("color") = "",
      nb::arg("bits") = nb::none(),
      nb::sig(
          "def process(self, left: ArrayLike, right: ArrayLike | None = None, *, disparity: ArrayLike | None = None, "
          "depth: ArrayLike | None = None, depth_scale: float | None = None, stamp_ns: int | None = None, "
          "pose: Pose | ArrayLike | None = None, other_grids: list[ObservedGrid] = [], color: str "
          "= '', bits: int | None = None) "
          "-> FrameResult"),
      "Processes rectified images (height, width): uint8, uint16, or floats from 0 to 255; (height, width, 3 or 4) "
      "uint8 with color \"rgb\" or \"bgr\". Instead of right, or beside it for features alone: disparity in px of "
      "left, "
      "or depth in m (uint16: depth_scale units are a metre). bits: number of lower bits of uint16 in use. stamp_ns: "
      "left out, 0.1 s after the frame "
      "before. "
      "pose: world_from_vehicle as Pose or (x_m, y_m, yaw_rad), or world_from_camera as 3 x 4 or 4 x 4 (x right, y "
      "down, z forward). other_grids: fused with the frame's own. Warns once of each kind of "
      "FrameResult.warnings.");
}

void bind_state(nb::class_<PyPipeline>& pipeline) {
  pipeline.def(
      "reset", [](PyPipeline& self) { self.exclusively([](Pipeline& p) { p.reset(); }); },
      "The next frame is a first one, whatever its stamp.");
  pipeline.def(
      "save_state",
      [](PyPipeline& self) {
        return self.exclusively([](const Pipeline& p) {
          const std::vector<std::byte> state{p.save_state()};
          return nb::bytes(reinterpret_cast<const char*>(state.data()), state.size());
        });
      },
      "Returns what the pipeline stores between two frames.");
  pipeline.def(
      "load_state",
      [](PyPipeline& self, const nb::bytes& state) {
        self.exclusively([&](Pipeline& p) {
          p.load_state({static_cast<const std::byte*>(state.data()), state.size()});
        });
      },
      nb::arg("state"), "Continues from save_state(). Raises InputError.");
  pipeline.def_prop_ro(
      "next_rig",
      [](PyPipeline& self) { return self.exclusively([](const Pipeline& p) { return MountedRig{p.next_rig()}; }); },
      "Rig of the next frame, with extrinsics estimated since.");
  pipeline.def_prop_ro(
      "memory_bytes",
      [](PyPipeline& self) { return self.exclusively([](const Pipeline& p) { return p.memory_use().host_bytes; }); },
      "Memory that the constructor has allocated on the host.");
}

}  // namespace

void bind_pipeline(nb::module_& module) {
  nb::class_<PyPipeline> pipeline{
      module, "Pipeline",
      "Stereo frames in, occupancy grids out. One pipeline serves the cameras of one vehicle, "
      "frame after frame, and one thread at a time."};
  pipeline.def("__init__", &construct, nb::arg("config"), nb::arg("rig"), nb::kw_only(), nb::arg("device") = nb::none(),
               nb::arg("threads") = nb::none(), nb::arg("stages") = nb::none(),
               nb::arg("horizons_s") = std::vector<double>{}, nb::arg("start") = nb::none(),
               nb::arg("in_world_of_poses") = PipelineOptions{}.in_world_of_poses,
               "rig: that of the camera, or those of up to eight cameras, which place them (camera_x_m, camera_y_m, "
               "camera_yaw_rad). device: \"auto\", \"cpu\", \"cuda\", \"cuda:N\" or \"reference\"; threads 0: all "
               "cores; stages False: "
               "results without stages; horizons_s: of FrameResult.predictions. Raises ConfigError, DeviceError.");
  bind_process(pipeline);
  bind_state(pipeline);
  bind_device_grids(module, pipeline);
  pipeline.def_prop_ro(
      "config", [](const PyPipeline& self) { return self.pipeline().config(); },
      "With automatic values resolved; a copy.");
  pipeline.def_prop_ro(
      "rig", [](const PyPipeline& self) { return MountedRig{self.pipeline().rig()}; }, "As given, without mask.");
  pipeline.def_prop_ro(
      "rigs",
      [](const PyPipeline& self) {
        const std::span rigs{self.pipeline().rigs()};
        std::vector<MountedRig> all;
        for (const Rig& rig : rigs) all.push_back({rig});
        return all;
      },
      "Rigs of all cameras, without masks.");
  pipeline.def_prop_ro(
      "grid", [](const PyPipeline& self) { return self.pipeline().vehicle_grid(); }, "Vehicle frame.");
  pipeline.def_prop_ro("threads", [](const PyPipeline& self) { return self.pipeline().threads(); });
  pipeline.def_prop_ro("device",
                       [](const PyPipeline& self) { return std::string{app::name_of(self.pipeline().back_end())}; });
  pipeline.def_prop_ro("why_not_cuda", [](const PyPipeline& self) { return self.pipeline().why_not_cuda(); });
}

}  // namespace stereogrid::python
