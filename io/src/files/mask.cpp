// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/mask.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {

Image<std::uint8_t> read_mask(const std::filesystem::path& path, int width_px, int height_px) {
  const std::string file{printable_path(path)};
  if (read_file(path, largest_bytes::image).starts_with("\xff\xd8")) {
    throw InputError{file, "is a JPEG, whose black is not quite 0.", "Save the mask as a PNG."};
  }
  const RgbImage image{read_rgb(path)};
  if (image.width != width_px || image.height != height_px) {
    throw InputError{file,
                     fmt::format("is a mask of {}×{} px, but the images have {}×{}.", image.width, image.height,
                                 width_px, height_px),
                     "A mask has the left image's size."};
  }
  Image<std::uint8_t> mask{width_px, height_px};
  for (std::size_t i{0}; i < mask.size(); ++i) {
    const std::uint8_t* const pixel{image.pixels.data() + 3 * i};
    mask.data()[i] = std::any_of(pixel, pixel + 3, [](std::uint8_t level) { return level != 0; }) ? 255 : 0;
  }
  if (std::ranges::none_of(mask, [](std::uint8_t pixel) { return pixel != 0; })) {
    throw InputError{file, "masks every pixel.", "Black (0) is what shows the vehicle; make the rest white."};
  }
  return mask;
}

Image<std::uint8_t> read_mask(const std::filesystem::path& path, const Calibration& calibration) {
  const Rig& rig{calibration.rig};
  Image<std::uint8_t> mask{read_mask(path, rig.width_px, rig.height_px)};
  if (!calibration.raw) return mask;
  mask = Rectifier{*calibration.raw, rig.width_px, rig.height_px}.left(mask);
  for (std::uint8_t& pixel : mask) pixel = pixel == 255 ? 255 : 0;
  return mask;
}

}  // namespace stereogrid::io
