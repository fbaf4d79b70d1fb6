// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Search paths of libstereogrid_cuda.so. A text file stands for it; the error names the file that could not be loaded.
#include <fstream>

#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* name{"libstereogrid_cuda.so"};

/// An installed program, started from another folder.
class Library : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const fs::path& folder : {bin(), prefix() / STEREOGRID_LIBRARY_FOLDER, elsewhere()})
      fs::create_directories(folder);
    fs::copy_file(STEREOGRID_TOOL, bin() / "stereogrid");
  }

  [[nodiscard]] fs::path prefix() const { return fs::canonical(folder_.path()) / "prefix"; }
  [[nodiscard]] fs::path bin() const { return prefix() / "bin"; }
  [[nodiscard]] fs::path elsewhere() const { return fs::canonical(folder_.path()) / "elsewhere"; }

  static void put_library(const fs::path& folder) { std::ofstream{folder / name} << "no library"; }

  /// Error of a run that requires the library; `program` as typed in the folder elsewhere.
  [[nodiscard]] std::string error_text(const std::string& program) const {
    const fs::path errors{folder_ / "errors"};
    const int code{shell("cd " + quoted(elsewhere().string()) +
                         " && unset STEREOGRID_CUDA_LIBRARY LD_LIBRARY_PATH && PATH=" + quoted(bin().string()) +
                         ":$PATH && " + program + " run " + quoted(small_scene("empty", "&frames=1")) +
                         " --device cuda --out ../run 2>" + quoted(errors.string()))};
    EXPECT_EQ(code, 75);
    return text_of(errors);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(Library, BesideTheProgramIsFoundHoweverTheProgramIsCalled) {
  put_library(bin());
  fs::create_symlink(bin() / "stereogrid", elsewhere() / "link");
  for (const char* program : {"stereogrid", "../prefix/bin/stereogrid", "./link", "\"$(command -v stereogrid)\""}) {
    EXPECT_THAT(error_text(program), HasSubstr((bin() / name).string() + " could not be loaded")) << program;
  }
}

TEST_F(Library, InThePrefixOfTheProgramIsFound) {
  put_library(prefix() / STEREOGRID_LIBRARY_FOLDER);
  EXPECT_THAT(error_text("stereogrid"),
              HasSubstr((bin() / ".." / STEREOGRID_LIBRARY_FOLDER / name).string() + " could not be loaded"));
}

TEST_F(Library, InTheCurrentFolderIsLeftAlone) {
  put_library(elsewhere());
  fs::create_directories(elsewhere() / ".." / STEREOGRID_LIBRARY_FOLDER);
  put_library(elsewhere() / ".." / STEREOGRID_LIBRARY_FOLDER);
  std::ofstream{elsewhere() / "stereogrid"} << "anything of that name";
  EXPECT_THAT(error_text("stereogrid"), Not(HasSubstr("could not be loaded")));
}

}  // namespace
}  // namespace stereogrid::app::testing
