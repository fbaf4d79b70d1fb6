// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace stereogrid::io {

constexpr std::string_view png_signature{"\x89PNG\r\n\x1a\n", 8};

/// `image`: 8 or 16 bits of one or three channels (B G R).
[[nodiscard]] std::string encode_png(const cv::Mat& image);

}  // namespace stereogrid::io
