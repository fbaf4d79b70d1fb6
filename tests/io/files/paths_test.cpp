// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/paths.hpp"

#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <functional>
#include <system_error>

#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

const auto all_queries = [](const fs::path& path) {
  return std::vector<std::function<void()>>{
      [path] { static_cast<void>(is_there(path)); }, [path] { static_cast<void>(is_folder(path)); },
      [path] { static_cast<void>(is_file(path)); }, [path] { static_cast<void>(has_entries(path)); },
      [path] { static_cast<void>(entries_of(path)); }};
};

TEST(Paths, TemporaryIsAllButAWrongPathAndAMissingPermission) {
  for (const int error : {EIO, ESTALE, EMFILE, ENFILE, ETIMEDOUT, ENOMEM, EPERM}) {
    EXPECT_TRUE(is_temporary(error)) << error;
    expect_error<DeviceError>([error] { throw_unreadable("drive/left", error); }, {"drive/left: ", "try again"});
  }
  for (const int error : {ENOENT, ENOTDIR, EACCES, ELOOP, ENAMETOOLONG}) {
    EXPECT_FALSE(is_temporary(error)) << error;
    expect_error([error] { throw_unreadable("drive/left", error); }, {"drive/left: ", "Check ", "permissions"});
  }
}

TEST(Paths, AreOfAKind) {
  const TemporaryFolder folder;
  put(folder / "full" / "file", "bytes");
  fs::create_directory(folder / "empty");
  fs::create_directory_symlink("full", folder / "link");
  fs::create_symlink("nowhere", folder / "dangling");
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  struct Case {
    std::string name;
    bool is_there, is_folder, is_file, has_entries;
    const char* first;
  };
  for (const Case& one :
       {Case{"full", true, true, false, true, ""}, Case{"full/file", true, false, true, false, "byt"},
        Case{"empty", true, true, false, false, ""}, Case{"link", true, true, false, true, ""},
        Case{"link/file", true, false, true, false, "byt"}, Case{"dangling", false, false, false, false, ""},
        Case{"no", false, false, false, false, ""}, Case{"full/file/no", false, false, false, false, ""},
        Case{std::string(300, 'x'), false, false, false, false, ""}, Case{"fifo", true, false, false, false, ""}}) {
    const fs::path path{folder / one.name};
    EXPECT_EQ(is_there(path), one.is_there) << path;
    EXPECT_EQ(is_folder(path), one.is_folder) << path;
    EXPECT_EQ(is_file(path), one.is_file) << path;
    EXPECT_EQ(has_entries(path), one.has_entries) << path;
    EXPECT_EQ(first_bytes(path, 3), one.first) << path;
  }
  put(folder / "full" / "a", "");
  EXPECT_EQ(entries_of(folder / "full"), (std::vector<fs::path>{folder / "full" / "a", folder / "full" / "file"}));
  EXPECT_EQ(first_bytes(folder / "full" / "file", 100), "bytes");
}

TEST(Paths, ThatCannotBeReadAreNotTakenForMissing) {
  const TemporaryFolder folder;
  fs::create_symlink("circle", folder / "circle");
  for (const auto& query : all_queries(folder / "circle")) expect_error(query, {"circle", "symbolic links"});
  EXPECT_EQ(first_bytes(folder / "circle", 3), "") << "of no known format";
  expect_error<DeviceError>([] { static_cast<void>(first_bytes("/proc/self/mem", 3)); }, {"nput/output", "again"});
  expect_error([&] { static_cast<void>(entries_of(folder / "no")); }, {"no: the folder cannot be read"});
}

TEST(Paths, CanBeReadLaterOnceThereAreDescriptors) {
  const TemporaryFolder folder;
  put(folder / "file", "x");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const auto listed = [](const fs::path& path) {
    with_path_errors([&] { return fs::directory_iterator{path} == fs::directory_iterator{}; });
  };
  // a sanitizer opens pipes at the first call of a class: of the errors' classes before there are none
  ASSERT_NE(std::generic_category().message(EMFILE), std::system_category().message(EACCES));
  expect_error([&] { listed(folder / "no"); }, {"no: ", "no such file"});
  const auto without_descriptors = [&](auto query) {
    std::exception_ptr error;
    const rlimit none{0, before.rlim_max};
    EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
    try {
      query();
    } catch (...) {
      error = std::current_exception();
    }
    ::setrlimit(RLIMIT_NOFILE, &before);
    ASSERT_TRUE(error);
    expect_error<DeviceError>([&] { std::rethrow_exception(error); }, {"oo many open files", "try again"});
  };
  without_descriptors([&] { static_cast<void>(entries_of(folder.path())); });
  without_descriptors([&] { static_cast<void>(first_bytes(folder / "file", 1)); });
  without_descriptors([&] { listed(folder.path()); });
}

TEST(Paths, ErrorsOfTheStandardLibraryAreTranslated) {
  const TemporaryFolder folder;
  expect_error([&] { with_path_errors([&] { return fs::file_size(folder / "no"); }); }, {"no: ", "no such file"});
  EXPECT_EQ(with_path_errors([] { return 3; }), 3);
}

}  // namespace
}  // namespace stereogrid::io::testing
