// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <turbojpeg.h>

#include <cstdint>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::io {
namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Destroy>;

std::size_t big_endian_16(std::string_view bytes, std::size_t at) {
  return static_cast<std::size_t>(static_cast<std::uint8_t>(bytes[at])) << 8 | static_cast<std::uint8_t>(bytes[at + 1]);
}

/// Marker at or after `at`, as libjpeg finds it: bytes of a scan, escaped 0xff and fill bytes are passed over.
std::size_t next_marker(std::string_view bytes, std::size_t at) {
  while (at + 1 < bytes.size() && (bytes[at] != '\xff' || bytes[at + 1] == '\0' || bytes[at + 1] == '\xff')) ++at;
  return at;
}

/// The decoder fills missing parts with grey, and each scan costs the time of an image.
void check_scans(const std::string& file, std::string_view bytes) {
  constexpr int most_scans{32};
  int scans{0};
  for (std::size_t at{next_marker(bytes, 2)}; at + 2 <= bytes.size(); at = next_marker(bytes, at)) {
    const auto marker{static_cast<std::uint8_t>(bytes[at + 1])};
    if (marker == 0xd9 && scans > 0) return;
    if (marker == 0xd9) break;
    at += 2;
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7)) continue;  // no length
    const std::size_t length{at + 2 <= bytes.size() ? big_endian_16(bytes, at) : 0};
    if (marker < 0xc0 || marker == 0xd8 || length < 2 || length > bytes.size() - at) break;
    if (marker == 0xda && ++scans > most_scans) {
      throw InputError{file, fmt::format("is a JPEG of more than {} scans.", most_scans), "Write it again."};
    }
    at += length;
  }
  fail_damaged(file, "is a truncated or damaged JPEG (its end is missing).");
}

/// Value of the tag Orientation in a TIFF header; 1: none.
int orientation_in(std::string_view tiff) {
  constexpr std::size_t tag_orientation{0x0112};
  constexpr std::size_t entry_bytes{12};
  if (tiff.size() < 8) return 1;
  const bool is_little{tiff.starts_with("II")};
  const auto number_at{[&](std::size_t at) {
    if (at > tiff.size() || tiff.size() - at < 2) return std::size_t{0};
    const std::size_t big{big_endian_16(tiff, at)};
    return is_little ? (big & 0xff) << 8 | big >> 8 : big;
  }};
  const std::size_t first{is_little ? number_at(4) | number_at(6) << 16 : number_at(4) << 16 | number_at(6)};
  const std::size_t entries{number_at(first)};
  for (std::size_t i{0}; i < entries; ++i) {
    const std::size_t at{first + 2 + i * entry_bytes};
    if (at + entry_bytes > tiff.size()) return 1;
    if (number_at(at) == tag_orientation) return static_cast<int>(number_at(at + 8));
  }
  return 1;
}

/// EXIF's orientation, 1 to 8; 1: as stored.
int orientation_of(std::string_view bytes) {
  constexpr std::string_view exif{"Exif\0\0", 6};
  for (std::size_t at{2}; at + 4 <= bytes.size() && bytes[at] == '\xff';) {
    const auto marker{static_cast<std::uint8_t>(bytes[at + 1])};
    const std::size_t length{big_endian_16(bytes, at + 2)};
    if (marker == 0xda || length < 2 || length > bytes.size() - at - 2) return 1;
    const std::string_view segment{bytes.substr(at + 4, length - 2)};
    if (marker == 0xe1 && segment.starts_with(exif)) return orientation_in(segment.substr(exif.size()));
    at += 2 + length;
  }
  return 1;
}

/// As OpenCV's imread turns images, with which they were calibrated.
cv::Mat turned(const cv::Mat& image, int orientation) {
  constexpr int about_u{0};
  constexpr int about_v{1};
  cv::Mat result{image};
  if (orientation >= 5 && orientation <= 8) cv::transpose(image, result);
  if (orientation == 2 || orientation == 6) cv::flip(result, result, about_v);
  if (orientation == 4 || orientation == 8) cv::flip(result, result, about_u);
  if (orientation == 3 || orientation == 7) cv::flip(result, result, -1);
  return result;
}

}  // namespace

cv::Mat decode_jpeg(const std::string& file, std::string_view bytes) {
  const Handle decoder{tjInitDecompress()};
  if (!decoder) throw std::bad_alloc{};
  const auto* const data{reinterpret_cast<const unsigned char*>(bytes.data())};
  int width{0};
  int height{0};
  int subsampling{0};
  int colours{-1};
  // fails for rare subsampling, which can be decoded
  static_cast<void>(tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colours));
  if (width > 0) check_size(file, static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
  check_scans(file, bytes);
  if (width <= 0 || colours < 0) fail_damaged(file);
  if (colours == TJCS_CMYK || colours == TJCS_YCCK) fail_unsupported(file, "is a JPEG in CMYK.");
  const bool is_grey{colours == TJCS_GRAY};
  cv::Mat image(height, width, is_grey ? CV_8UC1 : CV_8UC3, cv::Scalar::all(0));
  const auto decodes_into{[&](cv::Mat& pixels) {
    return tjDecompress2(decoder.get(), data, bytes.size(), pixels.data, width, 0, height,
                         is_grey ? TJPF_GRAY : TJPF_BGR, 0) == 0;
  }};
  const int orientation{orientation_of(bytes)};
  if (decodes_into(image)) return turned(image, orientation);
  if (tjGetErrorCode(decoder.get()) == TJERR_FATAL) fail_damaged(file);
  // A fatal error after a warning is reported as a warning: it leaves pixels unwritten.
  cv::Mat other{~image};
  decodes_into(other);
  if (cv::norm(image, other, cv::NORM_INF) > 0) fail_damaged(file);
  return turned(image, orientation);
}

std::vector<std::uint8_t> encode_jpeg(const PixelView& image, int quality) {
  const Handle encoder{tjInitCompress()};
  if (!encoder) throw std::bad_alloc{};
  const bool is_grey{image.format == PixelFormat::grey8};
  unsigned char* bytes{nullptr};
  unsigned long size{0};
  const int result{tjCompress2(encoder.get(), static_cast<const unsigned char*>(image.data), image.width_px,
                               static_cast<int>(image.stride_bytes), image.height_px, is_grey ? TJPF_GRAY : TJPF_BGR,
                               &bytes, &size, is_grey ? TJSAMP_GRAY : TJSAMP_420, quality, TJFLAG_ACCURATEDCT)};
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owned{bytes, tjFree};
  if (result != 0) throw InputError{"image", std::string{tjGetErrorStr2(encoder.get())} + ".", "Its size may be 0."};
  return {bytes, bytes + size};
}

}  // namespace stereogrid::io
