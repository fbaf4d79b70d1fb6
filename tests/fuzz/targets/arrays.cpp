// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/npz.hpp"
#include "stereogrid/io/recording.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

bool are_equal(const io::NpyArray& a, const io::NpyArray& b) {
  return a.dtype == b.dtype && a.shape == b.shape && a.bytes == b.bytes;
}

io::NpzArray for_writing(const std::string& name, const io::NpyArray& array) {
  io::NpzArray written{name, array.shape, std::span<const std::uint8_t>{}};
  written.dtype = array.dtype;
  written.bytes = array.bytes;
  return written;
}

void convert(const io::NpyArray& array) {
  require(array.to<float>().size() == array.size(), "an array changes its size");
  require(array.to<std::uint8_t>().size() == array.size(), "an array changes its size");
  require(array.to<std::int64_t>().size() == array.size(), "an array changes its size");
  accepts([&] { require(array.to_image<double>().size() == array.size(), "an array changes its size"); });
}

}  // namespace

FUZZ_TARGET(npy) {
  static const Folder folder;
  accepts([&] { convert(io::read_npy(folder.write("array.npy", text_of(input)))); });
}

FUZZ_TARGET(npz) {
  static const Folder folder;
  std::map<std::string, io::NpyArray> arrays;
  if (!accepts([&] { arrays = io::read_npz(folder.write("arrays.npz", text_of(input))); })) return;
  std::vector<io::NpzArray> written;
  for (const auto& [name, array] : arrays) {
    convert(array);
    written.push_back(for_writing(name, array));
  }
  if (!accepts([&] { io::write_npz(folder / "again.npz", written); })) return;
  const auto again{io::read_npz(folder / "again.npz")};
  require(again.size() == arrays.size(), "arrays are lost when they are written");
  for (const auto& [name, array] : arrays) {
    require(again.contains(name) && are_equal(again.at(name), array), "an array changes when it is written");
  }
}

FUZZ_TARGET(disparity) {
  static const Folder folder;
  Image<float> image;
  if (!accepts([&] { image = io::read_disparity(folder.write("disparity", text_of(input))); })) return;
  require(!image.empty(), "a disparity image without pixels");
  require(std::ranges::all_of(image, [](float d) { return std::isfinite(d) && d >= 0; }), "a disparity that is none");
}

FUZZ_TARGET(image) {
  static const Folder folder;
  const auto path{folder.write("image", text_of(input))};
  Image<std::uint8_t> grey;
  if (!accepts([&] { grey = io::read_grey(path); })) return;
  require(!grey.empty(), "an image without pixels");
  const int bits{io::sample_bits(path)};
  require(bits >= 8 && bits <= 16, "samples of no 8 to 16 bits");
  require(io::read_grey(path, bits) == grey, "an image that differs when its bits are notified");
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

FUZZ_TARGET(scan) {
  static const Folder folder;
  std::vector<io::ScanPoint> points;
  if (!accepts([&] { points = io::read_scan(folder.write("scan.bin", text_of(input))); })) return;
  require(!points.empty(), "a scan without points");
}

}  // namespace stereogrid::fuzz
