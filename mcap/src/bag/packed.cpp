// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <string>
#include <system_error>

#include "bag/bags.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::mcap {
namespace {

namespace fs = std::filesystem;

/// A folder that is gone at the end of its scope; files that are open stay readable.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name{(fs::temp_directory_path() / "stereogrid-XXXXXX").string()};
    if (::mkdtemp(name.data()) == nullptr) {
      throw DeviceError{fmt::format("{}: no folder can be created ({}). Set TMPDIR to a folder with space.", name,
                                    std::generic_category().message(errno))};
    }
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

struct Free {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

void unpack(const FileInput& packed, FileOutput& out, std::uint64_t always_bytes) {
  const std::unique_ptr<ZSTD_DCtx, Free> context{ZSTD_createDCtx()};
  if (!context) throw std::bad_alloc{};
  Bytes in(ZSTD_DStreamInSize());
  Bytes unpacked(ZSTD_DStreamOutSize());
  const std::uint64_t most_bytes{std::max(always_bytes, most_growth * packed.size())};
  std::uint64_t written{0};
  bool is_frame_whole{true};
  for (std::uint64_t at{0}; at < packed.size();) {
    const std::size_t count{static_cast<std::size_t>(std::min<std::uint64_t>(in.size(), packed.size() - at))};
    packed.read(at, std::span{in}.first(count));
    at += count;
    ZSTD_inBuffer input{in.data(), count, 0};
    bool is_full{false};  // the decoder may hold more
    while (input.pos < input.size || is_full) {
      ZSTD_outBuffer output{unpacked.data(), unpacked.size(), 0};
      const std::size_t left{ZSTD_decompressStream(context.get(), &output, &input)};
      if (ZSTD_isError(left) != 0) {
        throw InputError{packed.name(), "is a damaged zstd file.", "Copy or record it again."};
      }
      written += output.pos;
      if (written > most_bytes) {
        throw InputError{packed.name(), fmt::format("unpacks to more than {} times its size.", most_growth),
                         "Unpack it with zstd, and name the unpacked file."};
      }
      out.write(View{unpacked}.first(output.pos));
      is_full = output.pos == output.size;
      is_frame_whole = left == 0;
    }
  }
  if (!is_frame_whole) throw InputError{packed.name(), "is a truncated zstd file.", "Copy or record it again."};
}

}  // namespace

std::unique_ptr<Bag> open_packed_bag(const fs::path& path, std::uint64_t always_bytes) {
  const FileInput packed{path};
  const TemporaryFolder folder;
  const fs::path file{folder.path() / path.stem()};
  FileOutput out{file};
  unpack(packed, out, always_bytes);
  out.close();
  return open_unpacked_bag(file);
}

}  // namespace stereogrid::mcap
