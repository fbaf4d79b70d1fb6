// SPDX-License-Identifier: Apache-2.0
#include <tiffio.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>

#include "files/formats.hpp"

namespace stereogrid::io {
namespace {

/// A file in memory, as libtiff's calls use it.
struct Memory {
  std::string_view bytes;
  std::uint64_t at{0};
};

Memory& memory_of(thandle_t handle) {
  return *static_cast<Memory*>(handle);
}

tsize_t read(thandle_t handle, void* to, tsize_t size) {
  Memory& memory{memory_of(handle)};
  const std::uint64_t start{std::min<std::uint64_t>(memory.at, memory.bytes.size())};
  const std::string_view part{memory.bytes.substr(start, static_cast<std::size_t>(size))};
  std::ranges::copy(part, static_cast<char*>(to));
  memory.at = start + part.size();
  return static_cast<tsize_t>(part.size());
}

tsize_t refuse_to_write(thandle_t /*handle*/, void* /*from*/, tsize_t /*size*/) {
  return 0;
}

toff_t seek(thandle_t handle, toff_t offset, int origin) {
  Memory& memory{memory_of(handle)};
  memory.at = offset + (origin == SEEK_CUR ? memory.at : origin == SEEK_END ? memory.bytes.size() : 0);
  return memory.at;
}

int close(thandle_t /*handle*/) {
  return 0;
}

toff_t size_of(thandle_t handle) {
  return memory_of(handle).bytes.size();
}

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

Tiff open(const std::string& file, Memory& memory) {
  static const auto silenced{[] {
    TIFFSetWarningHandler(nullptr);
    return TIFFSetErrorHandler(nullptr);
  }()};
  static_cast<void>(silenced);
  Tiff tiff{TIFFClientOpen(file.c_str(), "rm", &memory, read, refuse_to_write, seek, close, size_of, nullptr, nullptr),
            TIFFClose};
  if (!tiff) fail_damaged(file);
  return tiff;
}

/// Numbers that a TIFF need not have.
std::uint16_t number(const Tiff& tiff, std::uint32_t tag) {
  std::uint16_t value{0};
  TIFFGetFieldDefaulted(tiff.get(), tag, &value);
  return value;
}

/// OpenCV's type of the pixels, or -1.
int type_of(const Tiff& tiff) {
  const int samples{number(tiff, TIFFTAG_SAMPLESPERPIXEL)};
  const std::uint16_t meaning{number(tiff, TIFFTAG_PHOTOMETRIC)};
  const bool is_plain{(meaning == PHOTOMETRIC_MINISBLACK && samples <= 2) ||
                      (meaning == PHOTOMETRIC_RGB && samples >= 3)};
  if (!is_plain || samples < 1 || samples > 4 || TIFFIsTiled(tiff.get()) != 0 ||
      (samples > 1 && number(tiff, TIFFTAG_PLANARCONFIG) != PLANARCONFIG_CONTIG)) {
    return -1;
  }
  const int bits{number(tiff, TIFFTAG_BITSPERSAMPLE)};
  if (number(tiff, TIFFTAG_SAMPLEFORMAT) == SAMPLEFORMAT_IEEEFP) {
    return samples > 1 ? -1 : bits == 32 ? CV_32FC1 : bits == 64 ? CV_64FC1 : -1;
  }
  if (number(tiff, TIFFTAG_SAMPLEFORMAT) != SAMPLEFORMAT_UINT || (bits != 8 && bits != 16)) return -1;
  return CV_MAKETYPE(bits == 8 ? CV_8U : CV_16U, samples);
}

}  // namespace

cv::Mat decode_tiff(const std::string& file, std::string_view bytes) {
  Memory memory{bytes};
  const Tiff tiff{open(file, memory)};
  std::uint32_t width{0};
  std::uint32_t height{0};
  TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
  check_size(file, width, height);
  const int type{type_of(tiff)};
  if (type < 0) {
    fail_unsupported(file, "is a TIFF with tiles, planes or a palette, or without 8 or 16 bits or floats a sample.");
  }
  cv::Mat image(static_cast<int>(height), static_cast<int>(width), type);
  if (static_cast<std::size_t>(TIFFScanlineSize(tiff.get())) != image.step[0]) fail_damaged(file);
  for (std::uint32_t v{0}; v < height; ++v) {
    if (TIFFReadScanline(tiff.get(), image.ptr(static_cast<int>(v)), v) < 0) fail_damaged(file);
  }
  if (image.channels() == 2) cv::extractChannel(image, image, 0);
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_RGBA2BGR);
  return image;
}

}  // namespace stereogrid::io
