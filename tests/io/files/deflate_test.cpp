// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "files/deflate.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace stereogrid::io::testing {
namespace {

TEST(Deflate, InflatesToWhatWasCompressed) {
  std::mt19937 generator{3};
  for (const std::size_t size : {0, 1, 15, 16, 17, 300, 70000}) {
    std::string bytes;
    while (bytes.size() < size) bytes += static_cast<char>(generator() % 7);
    std::vector<std::uint8_t> inflated(size);
    EXPECT_TRUE(inflate_zlib(deflate(bytes, DeflateForm::zlib), inflated));
    EXPECT_EQ(std::string(inflated.begin(), inflated.end()), bytes);
  }
}

}  // namespace
}  // namespace stereogrid::io::testing
