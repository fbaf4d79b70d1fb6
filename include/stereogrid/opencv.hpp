// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// For programs with OpenCV; the library itself does not include this.
#pragma once

#include <opencv2/core/mat.hpp>

#include "stereogrid/error.hpp"
#include "stereogrid/pixel_view.hpp"

namespace stereogrid {

/// View of a cv::Mat or of a part of one; its memory must outlive the view. `bits`: see PixelView. Throws InputError:
/// another type than CV_8UC1, CV_16UC1, CV_8UC3 (BGR) or CV_8UC4 (BGRA), or more than two dimensions.
[[nodiscard]] inline PixelView view_of(const cv::Mat& image, int bits = 16) {
  PixelView view{image.data,         image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step[0]),
                 PixelFormat::grey8, bits};
  switch (image.dims > 2 ? -1 : image.type()) {
    case CV_8UC1:
      return view;
    case CV_16UC1:
      view.format = PixelFormat::grey16;
      return view;
    case CV_8UC3:
      view.format = PixelFormat::bgr8;
      return view;
    case CV_8UC4:
      view.format = PixelFormat::bgra8;
      return view;
    default:
      throw InputError{"image", "is a cv::Mat of a type that is not taken.",
                       "Take CV_8UC1, CV_16UC1, CV_8UC3 (BGR) or CV_8UC4 (BGRA), in two dimensions."};
  }
}

}  // namespace stereogrid
