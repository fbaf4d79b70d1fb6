// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/interrupt.hpp"

#include <csignal>

#include "cli/console.hpp"

namespace stereogrid::app {
namespace {

// a signal handler has nothing else to write to
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
volatile std::sig_atomic_t received_signal{0};

extern "C" void note_signal(int signal) {
  received_signal = signal;
}

}  // namespace

void catch_interrupts() {
  limit_waits();
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // the terminal has gone: shell and system both may say so. nohup ignores it, and means it.
  struct sigaction inherited {};
  sigaction(SIGHUP, nullptr, &inherited);
  action.sa_flags = SA_RESTART;
  if (inherited.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

int interrupted() {
  return received_signal;
}

}  // namespace stereogrid::app
