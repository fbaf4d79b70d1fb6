// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <memory>
#include <vector>

namespace emulator {

/// Finds how many bytes of device memory each launch reads and writes, every one counted once: the memory is locked
/// before a launch, so that the first access to a page faults. Too many rather than too few, as pages count as a whole,
/// up to the end of their allocation. But what is read of a page that the launch has written to before is not counted.
class Traffic {
 public:
  /// Of the environment variable STEREOGRID_EMULATOR_TRAFFIC: the file that gets a line for each launch, with its
  /// blocks, threads of each, bytes read and bytes written. Nothing without it.
  static std::unique_ptr<Traffic> wanted();
  explicit Traffic(const char* file);

  void* allocate(std::size_t bytes);
  void release(void* memory);

  /// Around a launch, in the thread that runs it.
  void begin();
  void end(unsigned blocks, unsigned threads);

  /// Lets an access go on that has found `address` locked. False: that is no device memory.
  bool unlock(const void* address, bool reads, bool writes);

 private:
  struct Page {
    bool is_read{false};
    bool is_written{false};
  };
  struct Allocation {
    std::size_t bytes{0};
    std::vector<Page> pages;
  };

  std::ofstream file_;
  std::map<std::uintptr_t, Allocation> allocations_;
};

}  // namespace emulator
