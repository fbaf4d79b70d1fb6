// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace stereogrid {

/// Throws DeviceError unless the system gives this process `count` more threads. Starts them to find out, until that
/// has succeeded once: oneTBB starts threads from threads of its own, where a failure ends the program.
void require_threads(int count);

/// Within a handler: throws DeviceError for a failure of oneTBB or the standard library to start a thread, and anything
/// else again.
[[noreturn]] void rethrow_as_device_error(const std::runtime_error& error);

}  // namespace stereogrid
