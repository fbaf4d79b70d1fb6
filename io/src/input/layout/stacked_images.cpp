// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/recording_images.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stereogrid/error.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

Image<std::uint8_t> part_of(const Image<std::uint8_t>& image, int u_px, int v_px, Size size) {
  Image<std::uint8_t> part{size.width_px, size.height_px};
  for (int v{0}; v < size.height_px; ++v) std::copy_n(image.row(v_px + v) + u_px, size.width_px, part.row(v));
  return part;
}

bool can_be_cut(Size whole, ImageLayout layout) {
  return layout == ImageLayout::side_by_side ? whole.width_px % 2 == 0 : whole.height_px % 2 == 0;
}

/// Without complaints about the size or the principal point.
bool fits(const std::filesystem::path& calibration, Size size) {
  try {
    return read_calibration(calibration, size.width_px, size.height_px).warnings.empty();
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

Size size_of_part(Size whole, ImageLayout layout) {
  if (layout == ImageLayout::side_by_side) return {whole.width_px / 2, whole.height_px};
  return layout == ImageLayout::top_bottom ? Size{whole.width_px, whole.height_px / 2} : whole;
}

ImagePair split_pair(const Image<std::uint8_t>& image, int bits, ImageLayout layout, const std::string& name) {
  const Size whole{image.width(), image.height()};
  if (!can_be_cut(whole, layout)) {
    throw InputError{
        name, fmt::format("has {}×{} px, which two images of one size cannot share.", whole.width_px, whole.height_px),
        "Images side by side have an even width, one above the other an even height."};
  }
  const Size size{size_of_part(whole, layout)};
  const int u_px{layout == ImageLayout::side_by_side ? size.width_px : 0};
  const int v_px{layout == ImageLayout::top_bottom ? size.height_px : 0};
  return {part_of(image, 0, 0, size), part_of(image, u_px, v_px, size), bits, bits};
}

ImageLayout find_layout(Size whole, std::optional<ImageLayout> wanted, const std::filesystem::path& calibration,
                        const std::filesystem::path& images) {
  if (wanted) return *wanted;
  const auto is_possible{[&](ImageLayout layout) {
    return can_be_cut(whole, layout) && !calibration.empty() && fits(calibration, size_of_part(whole, layout));
  }};
  const bool beside{is_possible(ImageLayout::side_by_side)};
  const bool above{is_possible(ImageLayout::top_bottom)};
  if (beside != above) return beside ? ImageLayout::side_by_side : ImageLayout::top_bottom;
  if (whole.width_px >= 2 * whole.height_px) return ImageLayout::side_by_side;
  if (whole.width_px <= whole.height_px) return ImageLayout::top_bottom;
  throw InputError{printable_path(images),
                   fmt::format("has images of {}×{} px and no others: left and right image may share them, but it is "
                               "not clear how.",
                               whole.width_px, whole.height_px),
                   "Give --layout side-by-side or --layout top-bottom, or both cameras' images in left/ and right/."};
}

}  // namespace stereogrid::io
