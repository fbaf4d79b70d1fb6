// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/file.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <functional>
#include <sstream>
#include <thread>

#include "stereogrid/io/paths.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using Paths = FolderTest;
using ReadFile = FolderTest;
using WriteFile = FolderTest;

std::string content_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream{path, std::ios::binary}.rdbuf();
  return text.str();
}

std::ptrdiff_t files_in(const fs::path& folder) {
  return std::distance(fs::directory_iterator{folder}, {});
}

void refused(const fs::path& path, std::initializer_list<std::string_view> parts, std::size_t most = 100) {
  expect_error([&] { return read_file(path, most); }, parts);
}

TEST_F(ReadFile, ReadsRegularFilesOnly) {
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  refused(folder / "fifo", {"fifo", "FIFO", "Copy what it gives"});
  refused("/dev/zero", {"/dev/zero", "device"});
  refused(folder.path(), {"is a folder"});
  refused(folder / "missing", {"no such file"});
  refused(folder / std::string(300, 'x'), {"name too long"});
  fs::create_symlink("a", folder / "b");
  fs::create_symlink("b", folder / "a");
  refused(folder / "a", {"symbolic links"});
}

TEST_F(ReadFile, OfBoundedSize) {
  put(folder / "small", std::string(100, 'x'));
  EXPECT_EQ(read_file(folder / "small", 100), std::string(100, 'x'));
  refused(folder / "small", {"small", "most that such a file can have"}, 99);
  put(folder / "sparse", "x");
  fs::resize_file(folder / "sparse", std::uintmax_t{1} << 40);
  refused(folder / "sparse", {"sparse", "has more than 1 MB"}, largest_bytes::settings);
  EXPECT_GT(read_file("/proc/self/stat", 10'000).size(), 10U) << "of size 0, they say";
}

// Files of /sys say that they have 4096 bytes and end before, as one that becomes shorter while it is read.
TEST_F(ReadFile, NoticesThatAFileWasCutOff) {
  const fs::path shorter{"/sys/kernel/mm/transparent_hugepage/enabled"};
  std::error_code error;
  if (!fs::exists(shorter, error)) GTEST_SKIP() << "no " << shorter;
  refused(shorter, {"of its 4096 bytes", "cut off while it was read"}, 5000);
}

TEST_F(ReadFile, SeparatesTemporaryFromLastingErrors) {
  expect_error<DeviceError>([] { return read_file("/proc/self/mem"); }, {"nput/output", "try again"});
}

TEST(ReadText, IsWithoutAByteOrderMark) {
  const TemporaryFolder folder;
  put(folder / "a", "\xef\xbb\xbftext\xef\xbb\xbf");
  EXPECT_EQ(read_text(folder / "a", 100), "text\xef\xbb\xbf");
  put(folder / "b", "\xef\xbb");
  EXPECT_EQ(read_text(folder / "b", 100), "\xef\xbb");
}

TEST_F(WriteFile, FollowsSymbolicLinks) {
  put(folder / "there" / "target", "old");
  fs::create_symlink("there/target", folder / "link");
  fs::create_symlink(folder / "link", folder / "chain");
  write_file(folder / "chain", "new");
  EXPECT_EQ(content_of(folder / "there" / "target"), "new");
  EXPECT_TRUE(fs::is_symlink(folder / "chain"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(files_in(folder / "there"), 1);

  fs::create_symlink("there/made", folder / "dangling");
  write_file(folder / "dangling", "made");
  EXPECT_EQ(content_of(folder / "there" / "made"), "made");
  EXPECT_TRUE(fs::is_symlink(folder / "dangling"));

  fs::create_symlink("circle", folder / "circle");
  expect_error<DeviceError>([&] { write_file(folder / "circle", "x"); }, {"circle", "symbolic links"});
  EXPECT_TRUE(fs::is_symlink(folder / "circle"));
}

TEST_F(WriteFile, LeavesAFifoWhatItIs) {
  const fs::path fifo{folder / "fifo"};
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  std::string got;
  std::thread reader{[&] { got = content_of(fifo); }};
  write_file(fifo, "through the pipe");
  reader.join();
  EXPECT_EQ(got, "through the pipe");
  EXPECT_TRUE(fs::is_fifo(fifo));
  EXPECT_EQ(files_in(folder.path()), 1);
}

// Uses a device of its own: an error would remove the machine's /dev/full.
TEST_F(WriteFile, LeavesADeviceWhatItIs) {
  const fs::path full{folder / "full"};
  if (::mknod(full.c_str(), S_IFCHR | 0600, ::makedev(1, 7)) != 0) GTEST_SKIP() << "only root makes devices";
  expect_error<DeviceError>([&] { write_file(full, "x"); }, {"full: cannot be written"});
  EXPECT_TRUE(fs::is_character_file(full));
  EXPECT_EQ(files_in(folder.path()), 1);
}

TEST_F(WriteFile, KeepsThePermissionsOfAFileThatItReplaces) {
  put(folder / "secret", "old");
  fs::permissions(folder / "secret", fs::perms{0600});
  write_file(folder / "secret", "new");
  EXPECT_EQ(content_of(folder / "secret"), "new");
  EXPECT_EQ(fs::status(folder / "secret").permissions(), fs::perms{0600});
}

TEST_F(WriteFile, TakesEveryNameThatTheFileSystemTakes) {
  for (const std::size_t length : {1U, 200U, 242U, 246U, 247U, 248U, 255U}) {
    const fs::path path{folder / std::string(length, 'n')};
    write_file(path, "long");
    EXPECT_EQ(content_of(path), "long") << length;
  }
  EXPECT_EQ(files_in(folder.path()), 7);
  expect_error<DeviceError>([&] { write_file(folder / std::string(256, 'n'), "x"); }, {"name too long"});
}

TEST_F(WriteFile, RefusesAFolder) {
  fs::create_directory(folder / "a");
  expect_error<DeviceError>([&] { write_file(folder / "a", "x"); }, {"is a folder", "Name a file"});
  EXPECT_TRUE(fs::is_empty(folder / "a"));
}

TEST(CreateFolder, RejectsACircleOfLinks) {
  const TemporaryFolder folder;
  fs::create_symlink("circle", folder / "circle");
  expect_error<DeviceError>([&] { create_folder(folder / "circle"); }, {"circle", "cannot be made"});
  expect_error<DeviceError>([&] { create_folder(folder / "circle" / "a"); }, {"circle", "cannot be made"});
}

const auto all_queries = [](const fs::path& path) {
  return std::vector<std::function<void()>>{[path] { return is_there(path); }, [path] { return is_folder(path); },
                                            [path] { return is_file(path); }, [path] { return has_entries(path); },
                                            [path] { return entries_of(path); }};
};

TEST_F(Paths, TemporaryIsAllButAWrongPathAndAMissingPermission) {
  for (const int error : {EIO, ESTALE, EMFILE, ENFILE, ETIMEDOUT, ENOMEM, EPERM}) {
    EXPECT_TRUE(is_temporary(error)) << error;
    expect_error<DeviceError>([error] { throw_unreadable("drive/left", error); }, {"drive/left: ", "try again"});
  }
  for (const int error : {ENOENT, ENOTDIR, EACCES, ELOOP, ENAMETOOLONG}) {
    EXPECT_FALSE(is_temporary(error)) << error;
    expect_error([error] { throw_unreadable("drive/left", error); }, {"drive/left: ", "Check ", "permissions"});
  }
}

TEST_F(Paths, AreOfAKind) {
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

TEST_F(Paths, ThatCannotBeReadAreNotTakenForMissing) {
  fs::create_symlink("circle", folder / "circle");
  for (const auto& query : all_queries(folder / "circle")) expect_error(query, {"circle", "symbolic links"});
  EXPECT_EQ(first_bytes(folder / "circle", 3), "") << "of no known format";
  expect_error<DeviceError>([] { return first_bytes("/proc/self/mem", 3); }, {"nput/output", "again"});
  expect_error([&] { return entries_of(folder / "no"); }, {"no: the folder cannot be read"});
}

TEST_F(Paths, CanBeReadLaterOnceThereAreDescriptors) {
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
  without_descriptors([&] { return entries_of(folder.path()); });
  without_descriptors([&] { return first_bytes(folder / "file", 1); });
  without_descriptors([&] { listed(folder.path()); });
}

TEST_F(Paths, ErrorsOfTheStandardLibraryAreTranslated) {
  expect_error([&] { with_path_errors([&] { return fs::file_size(folder / "no"); }); }, {"no: ", "no such file"});
  EXPECT_EQ(with_path_errors([] { return 3; }), 3);
}

}  // namespace
}  // namespace stereogrid::io::testing
