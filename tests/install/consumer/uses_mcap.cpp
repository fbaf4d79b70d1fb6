// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes and reads a file with each compression, and opens a .db3: zstd, lz4, zlib and SQLite have to link and work.
#include <stereogrid/error.hpp>
#include <stereogrid/mcap/bag.hpp>
#include <stereogrid/mcap/writer.hpp>

#include <cstdio>
#include <fstream>
#include <span>
#include <string>

using namespace stereogrid;

int main() {
  bool fine{true};
  for (const auto compression : {mcap::Compression::none, mcap::Compression::lz4, mcap::Compression::zstd}) {
    const std::string text(1000, 'x');
    {
      mcap::Writer writer{"a.mcap", {.compression = compression}};
      writer.write(writer.add_channel("/x", "cdr", 0, {}), 1, 5, 5, std::as_bytes(std::span{text}));
      writer.close();
    }
    const auto bag{mcap::open_bag("a.mcap")};
    const auto cursor{bag->messages({})};
    const mcap::Message* const message{cursor->next()};
    fine = fine && message != nullptr && message->data.size() == text.size() && bag->topics()[0].name == "/x";
  }
  std::ofstream{"a.db3", std::ios::binary} << std::string{"SQLite format 3\0", 16};
  try {
    static_cast<void>(mcap::open_bag("a.db3"));
    fine = false;
  } catch (const InputError& error) {  // across the library's border
    std::printf("%s\n", error.what());
  }
  return fine ? 0 : 1;
}
