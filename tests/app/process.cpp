// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <thread>
#include <utility>

namespace stereogrid::app::testing {
namespace {

int code_of(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Process::Process(const std::vector<std::string>& words, int ignored) : Process{STEREOGRID_TOOL, words, ignored} {}

Process::Process(const std::string& program, const std::vector<std::string>& words, int ignored) {
  std::vector<std::string> copies{program};
  copies.insert(copies.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  id_ = fork();
  if (id_ != 0) return;
  // independent of the test's environment
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) signal(one, one == ignored ? SIG_IGN : SIG_DFL);
  const int nothing{open("/dev/null", O_RDWR)};
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
  execvp(program.c_str(), arguments.data());
  _exit(127);
}

Process::Process(Process&& other) noexcept : id_{std::exchange(other.id_, -1)} {}

Process::~Process() {
  if (id_ < 0) return;
  send(SIGKILL);
  wait();
}

void Process::send(int signal) const {
  kill(id_, signal);
}

int Process::wait() {
  int status{0};
  waitpid(std::exchange(id_, -1), &status, 0);
  return code_of(status);
}

std::optional<int> Process::wait_for(std::chrono::milliseconds limit) {
  const auto end{std::chrono::steady_clock::now() + limit};
  while (std::chrono::steady_clock::now() < end) {
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(id_), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (ended.si_pid == id_) return wait();
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
  return std::nullopt;
}

void Process::wait_until_it_catches_signals() const {
  for (int i{0}; i < 6000; ++i) {
    std::ifstream status{"/proc/" + std::to_string(id_) + "/status"};
    const std::string key{"SigCgt:\t"};
    for (std::string line; std::getline(status, line);) {
      if (!line.starts_with(key)) continue;
      if ((std::stoull(line.substr(key.size()), nullptr, 16) >> (SIGTERM - 1) & 1U) != 0) return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
}

int shell(const std::string& line) {
  return code_of(std::system(line.c_str()));
}

}  // namespace stereogrid::app::testing
