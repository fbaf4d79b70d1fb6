// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "input/calibration/yaml_group.hpp"

namespace stereogrid::io::opencv {

/// Names of a value in dumps of stereoCalibrate, in lower case without separators.
using Names = std::span<const std::string_view>;
inline constexpr std::string_view matrix_names[]{"m",
                                                 "k",
                                                 "cameramatrix",
                                                 "cammatrix",
                                                 "cm",
                                                 "mtx",
                                                 "matrix",
                                                 "intrinsic",
                                                 "intrinsics",
                                                 "intrinsicmatrix",
                                                 "cammtx",
                                                 "a",
                                                 "camera",
                                                 "kmatrix",
                                                 "cam",
                                                 "newcameramatrix",
                                                 "intrinsicsmatrix"};
inline constexpr std::string_view distortion_names[]{"d",
                                                     "dist",
                                                     "distcoeffs",
                                                     "distcoeff",
                                                     "distcoefs",
                                                     "distcoef",
                                                     "distortion",
                                                     "distortioncoeffs",
                                                     "distcoeffsmatrix",
                                                     "distortions",
                                                     "distortioncoefficients",
                                                     "distortionvector",
                                                     "coeffs"};
inline constexpr std::string_view rotation_names[]{"r",          "rot",       "rotation", "rotationmatrix",
                                                   "rmat",       "rvec",      "stereor",  "rstereo",
                                                   "extrinsicr", "rotmatrix", "rotmat"};
inline constexpr std::string_view translation_names[]{"t",       "trans",   "translation", "translationvector", "tvec",
                                                      "stereot", "tstereo", "extrinsict",  "transvector",       "tmat"};
inline constexpr std::string_view projection_names[]{"p",       "proj",   "projection", "projectionmatrix",
                                                     "projmat", "projmtx"};
inline constexpr std::string_view reprojection_names[]{"q", "qmatrix", "disparitytodepth", "disptodepth"};
inline constexpr std::string_view baseline_names[]{"baseline", "baselinem", "stereobaseline"};
inline constexpr std::string_view lens_names[]{
    "lens",       "lensmodel",       "lenstype",       "model",           "cameramodel",
    "cameratype", "distortionmodel", "distortiontype", "projectionmodel", "calibrationmodel"};
inline constexpr std::string_view unit_names[]{"unit", "units"};
inline constexpr std::string_view size_names[]{"imagesize", "size", "imgsize", "resolution", "framesize", "imsize"};
inline constexpr std::string_view width_names[]{"imagewidth",     "width",     "imgwidth",       "imwidth",
                                                "imagesizewidth", "sizewidth", "resolutionwidth"};
inline constexpr std::string_view height_names[]{"imageheight",     "height",     "imgheight",       "imheight",
                                                 "imagesizeheight", "sizeheight", "resolutionheight"};
inline constexpr std::string_view fx_names[]{"fx"};
inline constexpr std::string_view fy_names[]{"fy"};
inline constexpr std::string_view cx_names[]{"cx", "ppx", "u0"};
inline constexpr std::string_view cy_names[]{"cy", "ppy", "v0"};

struct Sides {
  std::string_view left;
  std::string_view right;
};
inline constexpr Sides all_sides[]{{"1", "2"}, {"0", "1"}, {"l", "r"}, {"left", "right"}, {"infra1", "infra2"}};

/// The key called by one of the names with `side` before or behind it; "": none. Of keys in groups (left.K) the path
/// counts, without words such as "stereo" and "camera".
[[nodiscard]] std::string find(const YamlGroup& flat, Names names, std::string_view side = "");

/// Sides of which both have a value of these names; nullptr: none.
[[nodiscard]] const Sides* sides_of(const YamlGroup& flat, Names names);

}  // namespace stereogrid::io::opencv
