// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/transfer.hpp"

#include <chrono>
#include <fstream>

#include "batch/child.hpp"
#include "batch/words.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::app::batch::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class BatchTransfer : public Folder {};

TEST_F(BatchTransfer, WordsAreTakenApartWithoutAShell) {
  EXPECT_THAT(words_of("rclone copy {uri} {dir}"), ElementsAre("rclone", "copy", "{uri}", "{dir}"));
  EXPECT_THAT(words_of("  a 'b  c'd \"e'f\" $g;h "), ElementsAre("a", "b  cd", "e'f", "$g;h"));
  EXPECT_THAT(words_of("a '' b"), ElementsAre("a", "", "b"));
  EXPECT_THROW(static_cast<void>(words_of("a 'b")), ConfigError);
  EXPECT_THROW(static_cast<void>(words_of("  ")), ConfigError);
  EXPECT_THROW(static_cast<void>(words_of("'' a")), ConfigError);
}

TEST_F(BatchTransfer, NamesAreFilledInOnceAndOthersRefused) {
  const std::map<std::string, std::string> values{{"dir", "{uri}"}, {"uri", "s3:a b"}};
  EXPECT_THAT(filled_in({"x{dir}y", "{uri}{uri}", "{}", "{A}", "{", "awk{print $1}"}, values),
              ElementsAre("x{uri}y", "s3:a bs3:a b", "{}", "{A}", "{", "awk{print $1}"));
  try {
    static_cast<void>(filled_in({"{file}"}, values));
    FAIL() << "taken";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("{file}: there is no such thing to fill in. There are: {dir}, {uri}."));
  }
}

TEST_F(BatchTransfer, PathsHaveTheUriOfTheFirstPrefixThatFits) {
  const std::vector<std::string> uris{"/mnt/a/b=s3:b", "/mnt/a/=s3:all/"};
  EXPECT_EQ(uri_of("/mnt/a/b/c", uris), "s3:b/c");
  EXPECT_EQ(uri_of("/mnt/a/b", uris), "s3:b");
  EXPECT_EQ(uri_of("/mnt/a/bc", uris), "s3:all/bc");
  EXPECT_EQ(uri_of("/mnt/ab", uris), "");
  EXPECT_EQ(uri_of("scene:street", uris), "");
  EXPECT_EQ(uri_of("/x", {"/=https://host"}), "https://host/x");
}

TEST_F(BatchTransfer, SizesHaveUnits) {
  EXPECT_EQ(bytes_of("17"), 17U);
  EXPECT_EQ(bytes_of("3K"), 3000U);
  EXPECT_EQ(bytes_of("50G"), 50'000'000'000U);
  for (const char* const none : {"", "G", "0", "-1", "1.5G", "5X", "5GB", "9999999T", "99999999999999999999"}) {
    EXPECT_THROW(static_cast<void>(bytes_of(none)), ConfigError) << none;
  }
}

TEST_F(BatchTransfer, ScratchFoldersOfTheDeadAreClearedAwayThoseOfOthersAreNot) {
  const fs::path dead{path() / "stereogrid-fetched-dead00"};
  fs::create_directories(dead / "drive");
  std::ofstream{dead / "drive" / "image"} << "bytes";
  std::ofstream{path() / "other"} << "stays";
  EXPECT_EQ(scratch_bytes(path()), 5U);
  {
    const ScratchFolder one{path()};
    std::ofstream{one.path() / "image"} << "seven b";
    const ScratchFolder two{path()};
    EXPECT_TRUE(fs::exists(one.path() / "image"));
    EXPECT_GE(scratch_bytes(path()), 7U);
  }
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(path() / "other"));
  EXPECT_EQ(scratch_bytes(path()), 0U);
}

TEST_F(BatchTransfer, ProgramsAreEndedWhenTheyTakeTooLong) {
  const auto nothing = [] { return std::string{}; };
  EXPECT_EQ(run_child({"true"}, 10, nothing), "");
  EXPECT_THAT(run_child({"false"}, 10, nothing), HasSubstr("exit code 1"));
  EXPECT_THAT(run_child({"sh", "-c", "kill -9 $$"}, 10, nothing), HasSubstr("signal 9"));
  EXPECT_THAT(run_child({(path() / "none").string()}, 10, nothing), HasSubstr("cannot be started"));
  const auto start{std::chrono::steady_clock::now()};
  EXPECT_THAT(run_child({"sleep", "100"}, 1, nothing), HasSubstr("took longer than 1 s"));
  EXPECT_EQ(run_child({"sleep", "100"}, 100, [] { return std::string{"enough"}; }), "enough");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds{20});
}

}  // namespace
}  // namespace stereogrid::app::batch::testing
