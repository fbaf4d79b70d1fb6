// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/ffmpeg.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <utility>

#include "files/file_access.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid::io {

Ffmpeg::Ffmpeg(Pipe pipe, std::vector<std::string> arguments) {
  std::vector<char*> words{const_cast<char*>("ffmpeg")};
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  int ends[2]{-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) throw DeviceError{fmt::format("no pipe to ffmpeg: {}.", reason(errno))};
  const bool is_input{pipe == Pipe::input};
  const Descriptor other{ends[is_input ? 0 : 1]};
  pipe_ = ends[is_input ? 1 : 0];
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, other.get(), is_input ? STDIN_FILENO : STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, is_input ? STDOUT_FILENO : STDIN_FILENO, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error{posix_spawnp(&process_, words.front(), &actions, &attributes, words.data(), environ)};
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error == 0) return;
  ::close(pipe_);
  throw DeviceError{
      fmt::format("videos need the program ffmpeg, which does not start: {}. Install it (apt-get install "
                  "ffmpeg).",
                  reason(error))};
}

Ffmpeg::~Ffmpeg() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  static_cast<void>(finish());
}

bool Ffmpeg::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written{::write(pipe_, bytes.data(), bytes.size())};
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::size_t Ffmpeg::read(char* to, std::size_t bytes) {
  std::size_t done{0};
  while (done < bytes) {
    const ssize_t count{::read(pipe_, to + done, bytes - done)};
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

bool Ffmpeg::finish() {
  ::close(std::exchange(pipe_, -1));
  int status{0};
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace stereogrid::io
