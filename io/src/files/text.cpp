// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

std::string frame_name(std::string_view text) {
  return printable(text, std::string::npos);
}

std::string printable_path(const std::filesystem::path& path) {
  return printable(path.native(), std::string::npos);
}

}  // namespace stereogrid::io
