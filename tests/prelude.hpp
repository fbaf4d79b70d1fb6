// SPDX-License-Identifier: Apache-2.0
//
// Headers of nearly every test: GoogleTest and the standard library; places of a grid. Included by each support.hpp,
// and precompiled.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "temporary_folder.hpp"

namespace stereogrid {

/// A test with a folder of its own.
struct FolderTest : testing::Test {
  const tests::TemporaryFolder folder;
};

/// Places (u, v) of columns [u_begin, u_end) and rows [v_begin, v_end), row by row.
inline std::vector<std::array<int, 2>> raster(int u_begin, int u_end, int v_begin, int v_end) {
  std::vector<std::array<int, 2>> places;
  for (int v{v_begin}; v < v_end; ++v) {
    for (int u{u_begin}; u < u_end; ++u) places.push_back({u, v});
  }
  return places;
}
inline std::vector<std::array<int, 2>> raster(int width, int height) {
  return raster(0, width, 0, height);
}
/// Places of an image, row by row.
inline std::vector<std::array<int, 2>> raster(const auto& image) {
  return raster(image.width(), image.height());
}

}  // namespace stereogrid
