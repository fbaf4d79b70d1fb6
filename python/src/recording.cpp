// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <tuple>
#include <variant>

#include "bindings.hpp"
#include "preset_choice.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/recording.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::python {
namespace {

namespace nb = nanobind;
using Path = std::filesystem::path;
using Paths = std::variant<Path, std::vector<Path>>;

std::shared_ptr<Recording> opened(app::InputOptions options, const std::string& frames) {
  app::Input input{app::open_input(options)};
  const io::FrameRange range{app::parse_frame_range(frames, input.source->size())};
  return std::make_shared<Recording>(std::make_shared<app::Input>(std::move(input)), std::move(options), range);
}

std::vector<std::string> texts_of(const Paths& paths) {
  if (const auto* path{std::get_if<Path>(&paths)}) return {path->string()};
  std::vector<std::string> texts;
  for (const Path& path : std::get<std::vector<Path>>(paths)) texts.push_back(path.string());
  if (texts.empty()) throw InputError{"open(): no path (expected a path, or a list of left and right)."};
  return texts;
}

std::string text_of(const std::optional<Path>& path) {
  return path ? path->string() : "";
}

std::shared_ptr<Recording> open(const Paths& paths, const std::optional<Path>& calibration,
                                const std::optional<Path>& poses, const std::optional<Path>& disparities,
                                bool with_right, const std::optional<Path>& depth, std::optional<double> depth_scale,
                                const std::optional<Path>& mask, const std::optional<Path>& labels,
                                const std::string& layout, const std::string& left_topic,
                                const std::string& right_topic, std::optional<double> pair_tolerance_ms,
                                const std::string& grid_topic, const std::string& frames,
                                const std::vector<std::string>& cameras) {
  app::InputOptions options;
  options.paths = texts_of(paths);
  options.calibration = text_of(calibration);
  options.poses = text_of(poses);
  options.disparities = text_of(disparities);
  options.with_right = with_right;
  options.depth = text_of(depth);
  options.depth_scale = depth_scale.value_or(options.depth_scale);
  options.mask = text_of(mask);
  options.labels = text_of(labels);
  options.layout = layout;
  options.left_topic = left_topic;
  options.right_topic = right_topic;
  options.pair_tolerance_ms = pair_tolerance_ms.value_or(options.pair_tolerance_ms);
  options.grid_topic = grid_topic;
  options.cameras = cameras;
  return opened(std::move(options), frames);
}

std::shared_ptr<Recording> simulate(const std::string& scene, std::optional<int> frames,
                                    std::optional<std::uint64_t> seed, std::optional<int> width_px,
                                    std::optional<int> height_px) {
  std::string text{(scene.starts_with("scene:") ? "" : "scene:") + scene};
  const auto add{[&text](const char* key, const auto& value) {
    if (value) text += (text.find('?') == std::string::npos ? "?" : "&") + std::string{key} + std::to_string(*value);
  }};
  add("frames=", frames);
  add("seed=", seed);
  add("width=", width_px);
  add("height=", height_px);
  app::InputOptions options;
  options.paths = {text};
  return opened(std::move(options), "");
}

std::size_t place_of(const Recording& recording, std::int64_t index) {
  const auto range{recording.range()};
  const auto size{static_cast<std::int64_t>(range.end - range.first)};
  const std::int64_t place{index < 0 ? index + size : index};
  if (place < 0 || place >= size)
    throw nb::index_error(("frame " + std::to_string(index) + " of " + std::to_string(size)).c_str());
  return range.first + static_cast<std::size_t>(place);
}

std::shared_ptr<Recording> frames_at(const Recording& self, const nb::slice& places) {
  const io::FrameRange range{self.range()};
  const auto [start, stop, step, count]{places.compute(range.end - range.first)};
  if (step != 1) throw nb::value_error(fmt::format("step {} of a slice of a recording (allowed 1).", step).c_str());
  if (count == 0) throw nb::index_error("The slice has no frames.");
  const std::size_t first{range.first + static_cast<std::size_t>(start)};
  return self.with({first, first + count});
}

std::unique_ptr<Frame> frame_at(const std::shared_ptr<Recording>& self, std::int64_t index) {
  const std::size_t place{place_of(*self, index)};
  const ReleasedGil release;
  auto frame{std::make_unique<Frame>()};
  frame->data = self->source().load(place);
  if (self->input().poses != app::PoseSource::input) frame->data.world_from_vehicle.reset();
  frame->recording = self;
  return frame;
}

void save(const Recording& self, const Path& folder, bool truth) {
  const bool with_truth{truth && self.has_truth()};
  io::PlainFolderWriter writer{folder, self.source().rigs(),
                               with_truth ? std::optional{self.truth_grid()} : std::nullopt};
  for (std::size_t i{self.range().first}; i < self.range().end; ++i) {
    const StereoFrame frame{self.source().load(i)};
    const std::optional<FrameTruth> known{with_truth ? std::optional{self.truth(i)} : std::nullopt};
    writer.write(frame, known ? &*known : nullptr);
    check_signals();
  }
  writer.finish();
}

std::string kind_of(const Recording& self) {
  if (self.input().scene != nullptr) return "built-in scene";
  return self.input().recording != nullptr ? self.input().recording->contents().kind : "arrays";
}

using Texts = std::vector<std::string>;

Texts contents_of(const Recording& self, Texts io::RecordingContents::*texts) {
  return self.input().recording != nullptr ? self.input().recording->contents().*texts : Texts{};
}

void bind_recording_class(nb::module_& module) {
  nb::class_<FrameIterator> iterator{module, "FrameIterator",
                                     "Frames of a recording in order, loaded in the background."};
  iterator.def(
      "__iter__", [](nb::handle self) { return nb::borrow(self); }, nb::sig("def __iter__(self) -> FrameIterator"));
  iterator.def("__next__", [](FrameIterator& self) {
    std::unique_ptr<Frame> frame{self.next()};
    if (!frame) throw nb::stop_iteration();
    return frame;
  });
  nb::class_<Recording> recording{
      module, "Recording",
      "An opened input. Iteration places the poses as stereogrid run does, skips frames that "
      "cannot be used with a SkippedFrameWarning, and may be repeated."};
  recording.def(
      nb::new_(&recording_of), nb::arg("frames"), nb::arg("rig"), nb::kw_only(), nb::arg("poses") = "",
      "Recording of frames in memory, in the order of their stamps; numbered anew. rig: of all cameras, if frames "
      "have others. poses: left out, those of the frames; \"none\" or \"odometry\". Raises InputError, ConfigError.");
  recording.def("__len__", [](const Recording& self) { return self.range().end - self.range().first; });
  recording.def("__iter__",
                [](const std::shared_ptr<Recording>& self) { return std::make_unique<FrameIterator>(self); });
  recording.def("__getitem__", &frame_at, nb::arg("index"),
                "Loads one frame. Its pose is that of the input; no visual odometry. Raises InputError, DeviceError.");
  recording.def("__getitem__", &frames_at, nb::arg("places"),
                "Returns a recording of consecutive frames; their indices are unchanged. Raises ValueError: a step; "
                "IndexError: no frames.");
  recording.def_prop_ro("rig", &Recording::rig, "Rig of the frames, for Pipeline.");
  recording.def_prop_ro("rigs", &Recording::rigs, "Rigs of all cameras, by Frame.camera; the first is rig.");
  recording.def_prop_ro("kind", &kind_of, "Such as \"KITTI odometry sequence\".");
  recording.def_prop_ro(
      "rate_hz", [](const Recording& self) { return app::rate_hz(self.input()); }, "Frames per second.");
  recording.def("__repr__", [](const Recording& self) {
    return fmt::format("Recording(kind='{}', frames={}, size_px=({}, {}), rate_hz={:.4g})", kind_of(self),
                       self.range().end - self.range().first, self.source().rig().width_px,
                       self.source().rig().height_px, app::rate_hz(self.input()));
  });
  recording.def_prop_ro(
      "notes", [](const Recording& self) { return contents_of(self, &io::RecordingContents::notes); },
      "Choices made on opening: calibration, poses, stamps.");
  recording.def_prop_ro(
      "warnings", [](const Recording& self) { return contents_of(self, &io::RecordingContents::warnings); },
      "Faults that do not stop the recording.");
  recording.def_prop_ro("has_truth", &Recording::has_truth, "Exact truth of scenes and rendered drives.");
  recording.def_prop_ro("truth_grid", &Recording::truth_grid, "Raises InputError: there is no truth.");
  recording.def_prop_ro(
      "skipped",
      [](const Recording& self) {
        std::vector<std::tuple<std::size_t, std::string, std::string>> frames;
        for (const io::SkippedFrame& frame : self.skipped) frames.emplace_back(frame.index, frame.name, frame.reason);
        return frames;
      },
      "(index, name, reason) of the frames that the last iteration has skipped.");
  recording.def("save", &save, nb::arg("folder"), nb::kw_only(), nb::arg("truth") = true, nb::call_guard<ReleasedGil>(),
                "Writes the frames as a plain folder, with truth where there is some. Raises InputError, DeviceError.");
}

}  // namespace

void bind_recording(nb::module_& module) {
  bind_recording_class(module);
  module.def("open", &open, nb::arg("path"), nb::kw_only(), nb::arg("calibration") = nb::none(),
             nb::arg("poses") = nb::none(), nb::arg("disparities") = nb::none(), nb::arg("with_right") = false,
             nb::arg("depth") = nb::none(), nb::arg("depth_scale") = nb::none(), nb::arg("mask") = nb::none(),
             nb::arg("labels") = nb::none(), nb::arg("layout") = "", nb::arg("left_topic") = "",
             nb::arg("right_topic") = "", nb::arg("pair_tolerance_ms") = nb::none(), nb::arg("grid_topic") = "",
             nb::arg("frames") = "", nb::arg("cameras") = std::vector<std::string>{}, nb::call_guard<ReleasedGil>(),
             "Opens what stereogrid run takes as INPUT: a folder, a bag of ROS 2, a list of left and right image or "
             "video, or \"scene:...\". The arguments are the options of stereogrid run; frames: \"FIRST:LAST\", both "
             "included. Raises InputError, ConfigError.");
  module.def("simulate", &simulate, nb::arg("scene"), nb::kw_only(), nb::arg("frames") = nb::none(),
             nb::arg("seed") = nb::none(), nb::arg("width_px") = nb::none(), nb::arg("height_px") = nb::none(),
             nb::call_guard<ReleasedGil>(),
             "Renders a built-in scene, such as \"street\" or \"scene:street?frames=60&seed=3\", with exact truth in "
             "Frame.truth. Raises InputError.");
  module.def("scene_names", &scenes::scene_names, "Returns the names of the built-in scenes.");
  module.def(
      "preset_for",
      [](const Recording& recording) {
        const ReleasedGil release;
        return app::choose_preset(recording.input()).preset;
      },
      nb::arg("recording"),
      "Returns the preset that \"auto\" takes: \"robot\" for a camera less than 0.6 m above the ground, else "
      "\"default\". Without mount in the calibration, the height is estimated from up to 10 frames. Raises "
      "DeviceError.");
  module.def(
      "preset_advice", [](const Config& self, const MountedRig& rig) { return app::advice_on_preset(self, rig.rig); },
      nb::arg("config"), nb::arg("rig"), "Returns which preset fits a camera so low; empty: that of config does.");
}

}  // namespace stereogrid::python
