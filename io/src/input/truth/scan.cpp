// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/scan.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

static_assert(sizeof(ScanPoint) == 4 * sizeof(float), "points are copied as they lie in the file");

std::vector<ScanPoint> read_scan(const std::filesystem::path& path) {
  const char* const mend{"Copy it again; a sweep is float32 x, y, z, reflectance for each point."};
  const std::string bytes{read_file(path, largest_bytes::sweep)};
  if (bytes.empty()) throw InputError{printable_path(path), "is empty.", mend};
  if (bytes.size() % sizeof(ScanPoint) != 0) {
    throw InputError{printable_path(path),
                     fmt::format("has {} bytes, which is no multiple of 16: it is cut off.", bytes.size()), mend};
  }
  std::vector<ScanPoint> points(bytes.size() / sizeof(ScanPoint));
  std::memcpy(points.data(), bytes.data(), bytes.size());
  // no lidar sees so far; what it says of such a point is no measurement
  constexpr float farthest_m{10'000};
  std::erase_if(points, [](const ScanPoint& point) {
    const auto is_near{[](float coordinate) { return std::abs(coordinate) <= farthest_m; }};  // false for NaN
    return !is_near(point.x_m) || !is_near(point.y_m) || !is_near(point.z_m);
  });
  if (points.empty())
    throw InputError{printable_path(path), "holds no point with finite coordinates within 10 km.", mend};
  return points;
}

}  // namespace stereogrid::io
