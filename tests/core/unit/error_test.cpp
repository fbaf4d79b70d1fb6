// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"

#include <gtest/gtest.h>

#include <string>

#include "stereogrid/config.hpp"

namespace stereogrid::test {
namespace {

// Texts of files, names and settings as they are.
TEST(Errors, QuotedBytesArePrintable) {
  EXPECT_STREQ(ConfigError{"a \xff\nb \x1b"}.what(), "a \\xFF\nb \\x1B") << "lines of a message stay";
  EXPECT_STREQ(InputError{"a \xff\nb \x1b"}.what(), "a \\xFF\nb \\x1B");
  EXPECT_STREQ(DeviceError{"a \xff\nb \x1b"}.what(), "a \\xFF\nb \\x1B");
  const InputError error{"fi\xffle", "has 'a\nb'.", "Put \xfe right."};
  EXPECT_STREQ(error.what(), "fi\\xFFle: has 'a\\x0Ab'. Put \\xFE right.");
}

TEST(Errors, MessagesAreOfBoundedLength) {
  const std::string lines(1'000'000, '\n');
  const std::string file(4'000, 'f');
  for (const std::string& longest : {lines, std::string(1'000'000, '\xff')}) {
    EXPECT_LT(std::string{ConfigError{longest}.what()}.size(), 17'000U);
    EXPECT_LT(std::string{InputError{longest}.what()}.size(), 17'000U);
    EXPECT_LT(std::string{DeviceError{longest}.what()}.size(), 17'000U);
    const std::string message{InputError{file, longest, longest}.what()};
    EXPECT_LT(message.size(), 9'000U);
    EXPECT_EQ(message.rfind(file + ": ", 0), 0U) << "paths are never shortened";
  }
}

TEST(Errors, SettingsAreQuotedPrintable) {
  Config config;
  for (const char* const key : {"no\xff", "grid.length_m", "ground.estimate", "ground.model"}) {
    try {
      set(config, key, "\xff");
      ADD_FAILURE() << key;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string{error.what()}.find("\\xFF"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
