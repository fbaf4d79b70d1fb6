// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/video.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "locks/descriptor.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app {
namespace {

/// Starts a program of the PATH, in a process group of its own: Ctrl-C stops us, not it. Returns 0 or errno.
int spawn(std::vector<std::string> words, int standard_input, pid_t& process) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, standard_input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error{posix_spawnp(&process, arguments.front(), &actions, &attributes, arguments.data(), environ)};
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

Video::Video(const std::filesystem::path& file, double rate_hz)
    : file_{file},
      unfinished_{file.parent_path() /
                  fmt::format(".{}.unfinished{}", file.stem().string(), file.extension().string())},
      rate_hz_{rate_hz} {
  pid_t probe{-1};
  if (spawn({"ffmpeg", "-version"}, STDIN_FILENO, probe) != 0) {
    throw DeviceError{"--video needs the program ffmpeg, which is not here. Install it (apt-get install ffmpeg)."};
  }
  waitpid(probe, nullptr, 0);
  if (file_.has_parent_path()) io::create_folder(file_.parent_path());
  std::signal(SIGPIPE, SIG_IGN);  // if ffmpeg ends early, write() says so
}

Video::~Video() {
  if (ffmpeg_ < 0) return;
  static_cast<void>(stop());
  std::error_code ignored;
  std::filesystem::remove(unfinished_, ignored);
}

void Video::start(int width, int height) {
  int ends[2]{-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw DeviceError{fmt::format("no pipe to ffmpeg: {}.", std::generic_category().message(errno))};
  pipe_ = ends[1];
  const int error{spawn({"ffmpeg",
                         "-loglevel",
                         "error",
                         "-y",
                         "-f",
                         "rawvideo",
                         "-pix_fmt",
                         "rgb24",
                         "-video_size",
                         fmt::format("{}x{}", width, height),
                         "-framerate",
                         fmt::format("{:.6g}", rate_hz_),
                         "-i",
                         "-",
                         "-vf",
                         "crop=trunc(iw/2)*2:trunc(ih/2)*2",
                         "-c:v",
                         "libx264",
                         "-pix_fmt",
                         "yuv420p",
                         "-crf",
                         "18",
                         "-movflags",
                         "+faststart",
                         unfinished_.string()},
                        ends[0], ffmpeg_)};
  ::close(ends[0]);
  if (error != 0) throw DeviceError{fmt::format("ffmpeg does not start: {}.", std::generic_category().message(error))};
}

void Video::add(const io::RgbImage& picture) {
  if (ffmpeg_ < 0) start(picture.width, picture.height);
  const auto* const bytes{reinterpret_cast<const char*>(picture.pixels.data())};
  if (write_all(pipe_, {bytes, picture.pixels.size()})) return;
  throw DeviceError{fmt::format("{}: ffmpeg has stopped early; its message stands above.", file_.string())};
}

bool Video::stop() {
  ::close(std::exchange(pipe_, -1));
  int status{0};
  while (waitpid(ffmpeg_, &status, 0) < 0 && errno == EINTR) {
  }
  ffmpeg_ = -1;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void Video::finish() {
  if (ffmpeg_ < 0) return;
  if (!stop()) {
    throw DeviceError{fmt::format("{}: ffmpeg could not make it; its message stands above.", file_.string())};
  }
  std::filesystem::rename(unfinished_, file_);
}

}  // namespace stereogrid::app
