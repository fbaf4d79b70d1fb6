// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/rigid.hpp"

#include <fmt/format.h>

#include "input/calibration/raw_pair.hpp"
#include "stereogrid/io/poses.hpp"

namespace stereogrid::io {

cv::Matx44d rigid_of(const std::vector<double>& numbers, const Origin& origin, const char* key) {
  std::vector<double> all{numbers};
  if (all.size() == 12) all.insert(all.end(), {0, 0, 0, 1});
  const char* const form{"It is 4 rows of 4: a rotation, the translation in the last column, and 0 0 0 1."};
  if (all.size() != 16) origin.fail(fmt::format("has a '{}' of {} numbers, not 16.", key, all.size()), form);
  const cv::Matx44d transform{all.data()};
  const auto is_end{[](double a, double b, double c, double d) { return a == 0 && b == 0 && c == 0 && d == 1; }};
  if (!is_end(transform(3, 0), transform(3, 1), transform(3, 2), transform(3, 3))) {
    const bool is_transposed{is_end(transform(0, 3), transform(1, 3), transform(2, 3), transform(3, 3))};
    origin.fail(fmt::format("has a '{}' that is {}.", key, is_transposed ? "transposed" : "no rigid transform"), form);
  }
  const cv::Matx33d turn{transform.get_minor<3, 3>(0, 0)};
  static_cast<void>(rotation_of({turn.val, turn.val + 9}, origin, key));
  return transform;
}

cv::Matx44d rigid_of(const std::array<double, 4>& quaternion, const cv::Vec3d& translation, const Origin& origin,
                     const char* key) {
  const auto unit{unit_quaternion(quaternion)};
  if (!unit) origin.fail(fmt::format("has in '{}' a quaternion whose length is not 1.", key), see_documentation);
  const auto& [x, y, z, w]{*unit};
  return rigid_of(cv::Matx33d{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
                              1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w),
                              1 - 2 * (x * x + y * y)},
                  translation);
}

cv::Matx44d rigid_of(const cv::Matx33d& r, const cv::Vec3d& t) {
  return {r(0, 0), r(0, 1), r(0, 2), t[0], r(1, 0), r(1, 1), r(1, 2), t[1],
          r(2, 0), r(2, 1), r(2, 2), t[2], 0,       0,       0,       1};
}

cv::Matx44d inverse(const cv::Matx44d& rigid) {
  const cv::Matx33d turn{rigid.get_minor<3, 3>(0, 0).t()};
  return rigid_of(turn, turn * cv::Vec3d{-rigid(0, 3), -rigid(1, 3), -rigid(2, 3)});
}

}  // namespace stereogrid::io
