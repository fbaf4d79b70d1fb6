// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/file.hpp"

#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cerrno>
#include <fstream>
#include <sstream>
#include <thread>

#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

std::string content_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream{path, std::ios::binary}.rdbuf();
  return text.str();
}

std::ptrdiff_t files_in(const fs::path& folder) {
  return std::distance(fs::directory_iterator{folder}, {});
}

void refused(const fs::path& path, std::initializer_list<std::string_view> parts, std::size_t most = 100) {
  expect_error([&] { static_cast<void>(read_file(path, most)); }, parts);
}

TEST(ReadFile, ReadsRegularFilesOnly) {
  const TemporaryFolder folder;
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

TEST(ReadFile, OfBoundedSize) {
  const TemporaryFolder folder;
  put(folder / "small", std::string(100, 'x'));
  EXPECT_EQ(read_file(folder / "small", 100), std::string(100, 'x'));
  refused(folder / "small", {"small", "most that such a file can have"}, 99);
  put(folder / "sparse", "x");
  fs::resize_file(folder / "sparse", std::uintmax_t{1} << 40);
  refused(folder / "sparse", {"sparse", "has more than 1 MB"}, largest_bytes::settings);
  EXPECT_GT(read_file("/proc/self/stat", 10'000).size(), 10U) << "of size 0, they say";
}

// Files of /sys say that they have 4096 bytes and end before, as one that becomes shorter while it is read.
TEST(ReadFile, NoticesThatAFileWasCutOff) {
  const fs::path shorter{"/sys/kernel/mm/transparent_hugepage/enabled"};
  std::error_code error;
  if (!fs::exists(shorter, error)) GTEST_SKIP() << "no " << shorter;
  refused(shorter, {"of its 4096 bytes", "cut off while it was read"}, 5000);
}

TEST(ReadFile, SeparatesTemporaryFromLastingErrors) {
  expect_error<DeviceError>([] { static_cast<void>(read_file("/proc/self/mem")); }, {"nput/output", "try again"});
}

TEST(ReadText, IsWithoutAByteOrderMark) {
  const TemporaryFolder folder;
  put(folder / "a", "\xef\xbb\xbftext\xef\xbb\xbf");
  EXPECT_EQ(read_text(folder / "a", 100), "text\xef\xbb\xbf");
  put(folder / "b", "\xef\xbb");
  EXPECT_EQ(read_text(folder / "b", 100), "\xef\xbb");
}

TEST(WriteFile, FollowsSymbolicLinks) {
  const TemporaryFolder folder;
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

TEST(WriteFile, LeavesAFifoWhatItIs) {
  const TemporaryFolder folder;
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
TEST(WriteFile, LeavesADeviceWhatItIs) {
  const TemporaryFolder folder;
  const fs::path full{folder / "full"};
  if (::mknod(full.c_str(), S_IFCHR | 0600, ::makedev(1, 7)) != 0) GTEST_SKIP() << "only root makes devices";
  expect_error<DeviceError>([&] { write_file(full, "x"); }, {"full: cannot be written"});
  EXPECT_TRUE(fs::is_character_file(full));
  EXPECT_EQ(files_in(folder.path()), 1);
}

TEST(WriteFile, KeepsThePermissionsOfAFileThatItReplaces) {
  const TemporaryFolder folder;
  put(folder / "secret", "old");
  fs::permissions(folder / "secret", fs::perms{0600});
  write_file(folder / "secret", "new");
  EXPECT_EQ(content_of(folder / "secret"), "new");
  EXPECT_EQ(fs::status(folder / "secret").permissions(), fs::perms{0600});
}

TEST(WriteFile, TakesEveryNameThatTheFileSystemTakes) {
  const TemporaryFolder folder;
  for (const std::size_t length : {1U, 200U, 242U, 246U, 247U, 248U, 255U}) {
    const fs::path path{folder / std::string(length, 'n')};
    write_file(path, "long");
    EXPECT_EQ(content_of(path), "long") << length;
  }
  EXPECT_EQ(files_in(folder.path()), 7);
  expect_error<DeviceError>([&] { write_file(folder / std::string(256, 'n'), "x"); }, {"name too long"});
}

TEST(WriteFile, RefusesAFolder) {
  const TemporaryFolder folder;
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

}  // namespace
}  // namespace stereogrid::io::testing
