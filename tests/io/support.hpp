// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "../temporary_folder.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/frame.hpp"

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

}  // namespace stereogrid::io::testing
