// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid::io {

/// The program ffmpeg with a pipe to its standard input or from its standard output. It is found in the PATH, and is in
/// a process group of its own: Ctrl-C stops the caller only.
class STEREOGRID_EXPORT Ffmpeg {
 public:
  enum class Pipe { input, output };

  /// Throws DeviceError: not installed, or it cannot start.
  Ffmpeg(Pipe pipe, std::vector<std::string> arguments);
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;
  /// Without finish(): ends the program.
  ~Ffmpeg();

  /// False: the program has ended early. SIGPIPE must be ignored.
  [[nodiscard]] bool write(std::string_view bytes);
  /// Returns the number of bytes read: below `bytes` only at the end of the output.
  [[nodiscard]] std::size_t read(char* to, std::size_t bytes);
  /// Closes the pipe and waits for the end of the program. False: it failed.
  [[nodiscard]] bool finish();

 private:
  int pipe_{-1};
  int process_{-1};
};

}  // namespace stereogrid::io
