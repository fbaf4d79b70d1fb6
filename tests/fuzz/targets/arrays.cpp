// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/npz.hpp"
#include "targets.hpp"

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

void npy(Bytes input) {
  static const Folder folder;
  accepts([&] { convert(io::read_npy(folder.write("array.npy", text_of(input)))); });
}

void npz(Bytes input) {
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

}  // namespace stereogrid::fuzz
