// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "stereogrid/io/disparity_file.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/scan.hpp"
#include "targets.hpp"

namespace stereogrid::fuzz {

void disparity(Bytes input) {
  static const Folder folder;
  Image<float> image;
  if (!accepts([&] { image = io::read_disparity(folder.write("disparity", text_of(input))); })) return;
  require(!image.empty(), "a disparity image without pixels");
  require(std::ranges::all_of(image, [](float d) { return std::isfinite(d) && d >= 0; }), "a disparity that is none");
}

void image(Bytes input) {
  static const Folder folder;
  const auto path{folder.write("image", text_of(input))};
  Image<std::uint8_t> grey;
  if (!accepts([&] { grey = io::read_grey(path); })) return;
  require(!grey.empty(), "an image without pixels");
  const int bits{io::sample_bits(path)};
  require(bits >= 8 && bits <= 16, "samples of no 8 to 16 bits");
  require(io::read_grey(path, bits) == grey, "an image that differs when its bits are told");
  accepts([&] {
    const Image<std::uint16_t> wide{io::read_u16(path)};
    require(wide.width() == grey.width() && wide.height() == grey.height(), "an image has two sizes");
  });
  accepts([&] {
    const io::RgbImage colour{io::read_rgb(path)};
    require(colour.width == grey.width() && colour.pixels.width() == 3 * grey.width(), "an image has two sizes");
  });
  io::write_png(folder / "again.png", grey);
  require(io::read_grey(folder / "again.png") == grey, "an image changes when it is written");
}

void scan(Bytes input) {
  static const Folder folder;
  std::vector<io::ScanPoint> points;
  if (!accepts([&] { points = io::read_scan(folder.write("scan.bin", text_of(input))); })) return;
  require(!points.empty(), "a scan without points");
}

}  // namespace stereogrid::fuzz
