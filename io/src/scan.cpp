// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/scan.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::io {

static_assert(sizeof(ScanPoint) == 4 * sizeof(float), "points are copied as they lie in the file");

std::vector<ScanPoint> read_scan(const std::filesystem::path& path) {
  const char* const mend{"Copy it again; a sweep is float32 x, y, z, reflectance for each point."};
  const std::string bytes{read_file(path)};
  if (bytes.empty()) throw InputError{path.string(), "is empty.", mend};
  if (bytes.size() % sizeof(ScanPoint) != 0) {
    throw InputError{path.string(),
                     fmt::format("has {} bytes, which is no multiple of 16: it is cut off.", bytes.size()), mend};
  }
  std::vector<ScanPoint> points(bytes.size() / sizeof(ScanPoint));
  std::memcpy(points.data(), bytes.data(), bytes.size());
  std::erase_if(points, [](const ScanPoint& point) {
    return !std::isfinite(point.x_m) || !std::isfinite(point.y_m) || !std::isfinite(point.z_m);
  });
  if (points.empty()) throw InputError{path.string(), "holds no point with finite coordinates.", mend};
  return points;
}

}  // namespace stereogrid::io
