// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "stereogrid/io/npz.hpp"

namespace stereogrid::io {

struct DTypeEntry {
  DType dtype;
  std::string_view spelling;
  std::size_t size;
};

constexpr std::array<DTypeEntry, 12> dtypes{{{DType::float16, "<f2", 2},
                                             {DType::float32, "<f4", 4},
                                             {DType::float64, "<f8", 8},
                                             {DType::int8, "|i1", 1},
                                             {DType::int16, "<i2", 2},
                                             {DType::int32, "<i4", 4},
                                             {DType::int64, "<i8", 8},
                                             {DType::uint8, "|u1", 1},
                                             {DType::uint16, "<u2", 2},
                                             {DType::uint32, "<u4", 4},
                                             {DType::uint64, "<u8", 8},
                                             {DType::boolean, "|b1", 1}}};

}  // namespace stereogrid::io
