// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>

#include "arrays.hpp"
#include "result.hpp"

namespace stereogrid::python {
namespace {

template <class T>
void bind_image(nb::class_<StageImages>& stages, const char* name, Image<T> StageImages::*image, const char* doc) {
  stages.def_prop_ro(
      name, [image](nb::handle self) { return view_of(nb::cast<const StageImages&>(self).*image, self); }, doc);
}

}  // namespace

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

}  // namespace stereogrid::python
