// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"

#include <atomic>
#include <chrono>
#include <thread>

namespace stereogrid::python {
namespace {

namespace nb = nanobind;

// Written with the GIL held.
struct Sections {
  std::atomic_int open{0};
  std::atomic_bool is_ending{false};
  std::thread::id ending_thread;

  [[nodiscard]] bool must_stop() const { return is_ending && std::this_thread::get_id() != ending_thread; }
};

Sections& sections() {
  static Sections all;
  return all;
}

// With the GIL held, which it releases. The process ends without this thread.
[[noreturn]] void stop_for_good() {
  PyEval_SaveThread();
  for (;;) std::this_thread::sleep_for(std::chrono::hours{1});
}

// Called by Python's atexit. Objects that threads still use are no leaks.
void end() {
  constexpr std::chrono::milliseconds between_looks{2};
  Sections& all{sections()};
  all.ending_thread = std::this_thread::get_id();
  all.is_ending = true;
  if (nb::cast<int>(nb::module_::import_("threading").attr("active_count")()) > 1) nb::set_leak_warnings(false);
  while (all.open > 0) {
    {
      const nb::gil_scoped_release release;
      std::this_thread::sleep_for(between_looks);
    }
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

}  // namespace

ReleasedGil::ReleasedGil() {
  if (sections().must_stop()) stop_for_good();
  ++sections().open;
  state_ = PyEval_SaveThread();
}

ReleasedGil::~ReleasedGil() {
  PyEval_RestoreThread(state_);
  --sections().open;
}

void check_signals() {
  const nb::gil_scoped_acquire acquire;
  if (sections().must_stop()) {
    --sections().open;
    stop_for_good();
  }
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

void bind_exit() {
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&end));
  const auto after_fork = [] {  // one thread, and objects of the others
    sections().open = 0;
    nb::set_leak_warnings(false);
  };
  nb::module_::import_("os").attr("register_at_fork")(nb::arg("after_in_child") = nb::cpp_function(after_fork));
}

}  // namespace stereogrid::python
