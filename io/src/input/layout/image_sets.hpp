// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "input/layout/natural_order.hpp"

namespace stereogrid::io {

/// Images by their name without extension.
using Images = std::map<std::string, std::filesystem::path, NaturalOrder>;

inline const std::set<std::string> image_extensions{".png",  ".pgm", ".ppm",  ".pnm",  ".jpg",
                                                    ".jpeg", ".tif", ".tiff", ".webp", ".bmp"};

/// Throws InputError: two of one name, names too long.
[[nodiscard]] Images images_in(const std::filesystem::path& folder, const std::set<std::string>& extensions);

/// The name of a frame is also that of files. Throws InputError where it is too long.
void check_length(const std::filesystem::path& file, const std::string& name);

/// Images of both cameras by the rest of their names; none: no two differ in a word for the side only.
struct NamedSides {
  Images left;
  Images right;
};

[[nodiscard]] std::optional<NamedSides> split_by_name(const Images& left, const Images& right);

}  // namespace stereogrid::io
