// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/child.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <optional>
#include <system_error>
#include <thread>

namespace stereogrid::app::batch {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int not_started{127};
constexpr std::chrono::seconds grace{5};

/// Only calls that are allowed between fork and exec of a program with threads.
[[noreturn]] void become(const std::vector<char*>& arguments, pid_t parent) {
  setpgid(0, 0);  // so that its children can be ended with it
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(not_started);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(signal, SIG_DFL);
  close(STDIN_FILENO);
  dup2(STDERR_FILENO, STDOUT_FILENO);
  execvp(arguments.front(), arguments.data());
  _exit(not_started);
}

/// None: it goes on.
std::optional<int> status_of(pid_t child) {
  int status{0};
  for (;;) {
    const pid_t found{waitpid(child, &status, WNOHANG)};
    if (found == child) return status;
    if (found < 0 && errno == EINTR) continue;
    return found < 0 ? std::optional{not_started << 8} : std::nullopt;
  }
}

void end(pid_t child) {
  kill(-child, SIGTERM);
  const auto deadline{Clock::now() + grace};
  while (!status_of(child)) {
    if (Clock::now() > deadline) kill(-child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }
  kill(-child, SIGKILL);  // its children
}

std::string text_of(const std::string& program, int status) {
  if (WIFSIGNALED(status)) return fmt::format("{} was ended by signal {}", program, WTERMSIG(status));
  const int code{WEXITSTATUS(status)};
  if (code == 0) return "";
  if (code == not_started) return fmt::format("{} cannot be started, or has ended with exit code {}", program, code);
  return fmt::format("{} has ended with exit code {}", program, code);
}

}  // namespace

std::string run_child(const std::vector<std::string>& words, int limit_s, const std::function<std::string()>& trouble) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent{getpid()};
  const pid_t child{fork()};
  if (child < 0) return "no process can be started: " + std::generic_category().message(errno);
  if (child == 0) become(arguments, parent);
  setpgid(child, child);  // whoever of both is first
  const auto deadline{Clock::now() + std::chrono::seconds{limit_s}};
  for (auto pause{std::chrono::milliseconds{1}};; pause = std::min(2 * pause, std::chrono::milliseconds{100})) {
    if (const auto status{status_of(child)}) return text_of(words.front(), *status);
    std::string why{trouble()};
    if (why.empty() && Clock::now() > deadline) why = fmt::format("{} took longer than {} s", words.front(), limit_s);
    if (!why.empty()) {
      end(child);
      return why;
    }
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace stereogrid::app::batch
