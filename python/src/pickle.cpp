// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "bindings.hpp"
#include "pipeline.hpp"
#include "recording.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::python {
namespace {

/// Appends values to a state, or reads them from one. Only the version that has written a state can read it: values are
/// as they are in memory.
class Archive {
 public:
  /// Writes.
  Archive() = default;
  /// Reads.
  explicit Archive(const nb::bytes& state) : is_reading_{true}, state_{state.c_str(), state.size()} {}

  [[nodiscard]] nb::bytes state() const { return nb::bytes(state_.data(), state_.size()); }

  template <class... Values>
  void operator()(Values&... values) {
    (value(values), ...);
  }

 private:
  void raw(void* at, std::size_t bytes) {
    if (!is_reading_) {
      state_.append(static_cast<const char*>(at), bytes);
      return;
    }
    if (bytes > state_.size() - place_) throw InputError{"The pickled object is cut off. Pickle it again."};
    std::memcpy(at, state_.data() + place_, bytes);
    place_ += bytes;
  }

  /// Number of elements that follow; bounded by what the state holds.
  std::size_t count(std::size_t size) {
    raw(&size, sizeof size);
    if (is_reading_ && size > state_.size()) throw InputError{"The pickled object is damaged. Pickle it again."};
    return size;
  }

  template <class T>
  void value(T& plain) {
    static_assert(std::is_trivially_copyable_v<T>);
    raw(&plain, sizeof plain);
  }
  void value(std::string& text) {
    text.resize(count(text.size()));
    raw(text.data(), text.size());
  }
  template <class T>
  void value(std::optional<T>& optional) {
    bool has_value{optional.has_value()};
    value(has_value);
    if (has_value && !optional) optional.emplace();
    if (has_value) value(*optional);
  }
  template <class T>
  void value(std::vector<T>& values) {
    values.resize(count(values.size()));
    for (T& element : values) value(element);
  }
  template <class T>
  void value(Image<T>& image) {
    const std::size_t width{count(static_cast<std::size_t>(image.width()))};
    const std::size_t height{count(static_cast<std::size_t>(image.height()))};
    if (is_reading_) image = Image<T>{static_cast<int>(width), static_cast<int>(height)};
    raw(image.data(), image.size() * sizeof(T));
  }
  void value(Warning& warning) { (*this)(warning.text, warning.status); }
  void value(ObservedGrid& grid) { (*this)(grid.geometry, grid.occupancy, grid.confidence); }
  void value(Prediction& p) { (*this)(p.horizon_s, p.occupancy, p.world_occupancy); }
  void value(GridLayers& l) {
    (*this)(l.geometry, l.occupancy, l.velocity_x, l.velocity_y, l.age_s, l.velocity_xx, l.velocity_xy, l.velocity_yy,
            l.moving);
  }
  void value(StageImages& s) {
    (*this)(s.obstacle_disparity, s.road_disparity, s.match_confidence, s.ambiguous, s.possible, s.visible, s.observed,
            s.visibility, s.obstacle_confidence, s.road_confidence, s.occupancy, s.occupancy_smooth);
  }
  void value(StereoFrame& f) {
    (*this)(f.name, f.index, f.stamp_ns, f.left, f.right, f.disparity, f.world_from_vehicle, f.other_grids, f.labels,
            f.camera, f.others);
  }
  void value(FrameResult& r) {
    (*this)(r.rig, r.level_rig, r.ground, r.world_from_vehicle, r.obstacle_density, r.road_density, r.observed,
            r.elevation_m, r.elevation_sigma_m, r.terrain, r.witness, r.world_elevation_m, r.world_elevation_sigma_m,
            r.world_terrain, r.speed_limit_mps, r.speed_limit_reason, r.vehicle, r.world, r.predictions, r.obstacles,
            r.stages, r.timing_ms, r.status, r.warnings, r.exposure, r.cameras, r.has_images, r.camera_name);
  }

  bool is_reading_{false};
  std::string state_;
  std::size_t place_{0};
};

void archive(Archive& values, Frame& frame) {
  values(frame.data, frame.warning, frame.odometry_ms);
}

void archive(Archive& values, Result& result) {
  values(result.name, result.index, result.stamp_ns, result.data);
}

/// Defines the state of a class for pickle. `construct(at)` makes an object in place.
template <class Class, class Construct>
void bind_pickle(nb::handle module, const char* name, const Construct& construct) {
  auto bound{nb::borrow<nb::class_<Class>>(module.attr(name))};
  bound.def("__getstate__", [](Class& self) {
    Archive values;
    std::string writer{version()};
    values(writer);
    archive(values, self);
    return values.state();
  });
  bound.def("__setstate__", [construct](Class& self, const nb::bytes& state) {
    Archive values{state};
    std::string writer;
    values(writer);
    if (writer != version()) {
      throw InputError{fmt::format("The object was pickled by version {} of stereogrid (allowed: {}). Pickle it again.",
                                   writer, version())};
    }
    archive(values, *construct(&self));
  });
}

}  // namespace

void bind_pickling(nb::module_& module) {
  bind_pickle<Frame>(module, "Frame", [](Frame* at) { return new (at) Frame; });
  bind_pickle<Result>(module, "FrameResult",
                      [](Result* at) { return new (at) Result{std::make_shared<ResultPool>()}; });
}

}  // namespace stereogrid::python
