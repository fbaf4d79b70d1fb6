// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

#include <zlib.h>

#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <random>

namespace stereogrid::io::testing {

std::optional<fs::path> data_folder() {
  const char* const named{std::getenv("STEREOGRID_DATA")};
  const fs::path folder{named != nullptr ? fs::path{named}
                                         : fs::path{STEREOGRID_SOURCE_DIR} / ".." / "shared" / "data"};
  return fs::is_directory(folder) ? std::optional{folder.lexically_normal()} : std::nullopt;
}

void expect_no_recording(const InputArguments& arguments, std::initializer_list<std::string_view> parts) {
  expect_error([&] { return open_recording(arguments); }, parts);
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift{24}; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

std::string png_chunk(const std::string& type, const std::string& content) {
  const std::string covered{type + content};
  return big_endian(static_cast<std::uint32_t>(content.size())) + covered +
         big_endian(static_cast<std::uint32_t>(
             crc32(0, reinterpret_cast<const Bytef*>(covered.data()), static_cast<uInt>(covered.size()))));
}

void put(const fs::path& path, std::string_view text) {
  fs::create_directories(path.parent_path());
  std::ofstream{path, std::ios::binary} << text;
}

bool run_python(const std::string& script) {
  const TemporaryFolder folder;
  put(folder / "script.py", script);
  return std::system(("/usr/bin/python3 " + (folder / "script.py").string()).c_str()) == 0;
}

bool has_numpy() {
  return std::system("/usr/bin/python3 -c 'import numpy' >/dev/null 2>&1") == 0;
}

StereoFrame textured_pair(int width, int height, int disparity_px, unsigned seed) {
  std::mt19937 random{seed};
  cv::Mat texture(height, width + disparity_px, CV_8UC1);
  for (const auto [u, v] : raster(texture.cols, texture.rows))
    texture.at<uchar>(v, u) = static_cast<uchar>(random() >> 24);
  cv::GaussianBlur(texture, texture, {5, 5}, 1.2);
  StereoFrame frame;
  frame.name = "textured";
  frame.left = Image<std::uint8_t>{width, height};
  frame.right = Image<std::uint8_t>{width, height};
  for (const auto [u, v] : raster(width, height)) {
    frame.left(u, v) = texture.at<uchar>(v, u);
    frame.right(u, v) = texture.at<uchar>(v, u + disparity_px);
  }
  return frame;
}

}  // namespace stereogrid::io::testing
