// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace stereogrid::tests {

/// A new folder, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name{(std::filesystem::temp_directory_path() / "stereogrid_test_XXXXXX").string()};
    if (::mkdtemp(name.data()) == nullptr) throw std::system_error{errno, std::generic_category(), name};
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
  /// Writes a file and returns its path. `name` may contain sub-folders.
  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    const std::filesystem::path file{path_ / name};
    std::filesystem::create_directories(file.parent_path());
    std::ofstream stream{file, std::ios::binary};
    if (!stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush()) {
      throw std::runtime_error{file.string() + " cannot be written"};
    }
    return file;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace stereogrid::tests
