// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "support.hpp"

namespace {
stereogrid::fuzz::Target target;
}

// The target is named by the environment, which processes that libFuzzer starts have, too.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* name{std::getenv("STEREOGRID_FUZZ_TARGET")};
  for (const auto& known : stereogrid::fuzz::targets()) {
    if (name != nullptr && std::string_view{known.name} == name) target = known;
  }
  if (target.run == nullptr) {
    std::fprintf(stderr, "STEREOGRID_FUZZ_TARGET has to name a target (tests/fuzz/targets)\n");
    std::exit(64);
  }
  return 0;
}

// An exception that leaves it is a finding to libFuzzer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target.run({data, size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t largest);

namespace {

std::size_t big_endian(const std::uint8_t* bytes) {
  return std::size_t{bytes[0]} << 24 | std::size_t{bytes[1]} << 16 | std::size_t{bytes[2]} << 8 | std::size_t{bytes[3]};
}

void write_big_endian(std::uint8_t* bytes, std::size_t value) {
  for (int i{0}; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

/// Gives every chunk the checksum of what it holds now, and the last one a length that fits.
void mend_checksums(std::uint8_t* png, std::size_t size) {
  for (std::size_t at{8}; at + 12 <= size;) {
    const std::size_t length{std::min(big_endian(png + at), size - at - 12)};
    write_big_endian(png + at, length);
    write_big_endian(png + at + 8 + length, ::crc32(0, png + at + 4, static_cast<uInt>(length + 4)));
    at += length + 12;
  }
}

}  // namespace

// PNG readers refuse a chunk with a wrong checksum before they read it. One in eight keeps its faults.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t largest,
                                               unsigned seed) {
  size = LLVMFuzzerMutate(data, size, largest);
  const std::string_view bytes{reinterpret_cast<const char*>(data), size};
  if (bytes.starts_with("\x89PNG\r\n\x1a\n") && seed % 8 != 0) mend_checksums(data, size);
  return size;
}
