// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "../temporary_folder.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/recording.hpp"

namespace stereogrid::io::testing {

namespace fs = std::filesystem;

using tests::TemporaryFolder;

/// The project's data sets; none: not on this machine.
[[nodiscard]] std::optional<fs::path> data_folder();

[[nodiscard]] std::string big_endian(std::uint32_t value);
/// A chunk of a PNG, with its length and checksum.
[[nodiscard]] std::string png_chunk(const std::string& type, const std::string& content);

/// Makes the parent folders too.
void put(const fs::path& path, std::string_view text);

/// Runs a script with the system's Python; false: it failed. Skips nothing itself.
[[nodiscard]] bool run_python(const std::string& script);
[[nodiscard]] bool has_numpy();

/// A textured plane seen at one disparity.
[[nodiscard]] StereoFrame textured_pair(int width, int height, int disparity_px, unsigned seed = 1);

/// Expects `action` to throw an Error whose text holds all of `parts`.
template <class Error = InputError, class Action>
void expect_error(Action&& action, std::initializer_list<std::string_view> parts) {
  try {
    action();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    for (const std::string_view part : parts) EXPECT_THAT(error.what(), ::testing::HasSubstr(std::string{part}));
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
  }
}

/// Expects an input to be refused.
void expect_no_recording(const InputArguments& arguments, std::initializer_list<std::string_view> parts);

constexpr int small_width_px{65};
constexpr int small_height_px{33};

constexpr const char* small_yaml{
    "image: {width_px: 65, height_px: 33}\nfocal_px: 60\ncx_px: 32\ncy_px: 16\nbaseline_m: 0.2\n"
    "mount: {camera_height_m: 1.2}\n"};
constexpr const char* small_calib{
    "P0: 60 0 32 0 0 60 16 0 0 0 1 0\nP1: 60 0 32 -30 0 60 16 0 0 0 1 0\n"
    "P2: 60 0 32 3 0 60 16 0 0 0 1 0\nP3: 60 0 32 -24 0 60 16 0 0 0 1 0\n"};

/// Left images are 10, 11, … grey all over, right ones 100 brighter.
inline void put_pairs(const fs::path& left, const fs::path& right, const std::vector<std::string>& names) {
  fs::create_directories(left);
  fs::create_directories(right);
  for (std::size_t i{0}; i < names.size(); ++i) {
    const auto grey{static_cast<std::uint8_t>(10 + i)};
    write_png(left / (names[i] + ".png"), Image<std::uint8_t>{small_width_px, small_height_px, grey});
    write_png(right / (names[i] + ".png"),
              Image<std::uint8_t>{small_width_px, small_height_px, static_cast<std::uint8_t>(grey + 100)});
  }
}

/// A KITTI odometry sequence of frames 000046 … 000048.
inline void put_odometry(const fs::path& root) {
  put_pairs(root / "image_0", root / "image_1", {"000046", "000047", "000048"});
  put(root / "calib.txt", small_calib);
  put(root / "times.txt", "0.0\n1.041284e-01\n0.2\n");
  put(root / "poses_gt.txt", "1 0 0 0 0 1 0 0 0 0 1 7\n1 0 0 0 0 1 0 0 0 0 1 8\n1 0 0 0 0 1 0 0 0 0 1 9\n");
}

/// Three frames a, b, c in the plain-folder layout.
inline void put_plain(const fs::path& root) {
  put_pairs(root / "left", root / "right", {"a", "b", "c"});
  put(root / "calibration.yaml", small_yaml);
  put(root / "poses.csv", "name,stamp_ns,x_m,y_m,yaw_rad\na,5,0,0,0\nb,100000005,1,0,0\nc,200000005,2,0,0.1\n");
}

}  // namespace stereogrid::io::testing
