// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace stereogrid::dds {

/// Passes warnings of Cyclone DDS in this process to `warn`, each once: a pulled cable causes one per packet. Texts
/// that differ in numbers only are the same.
void take_network_log(std::function<void(const std::string&)> warn);

}  // namespace stereogrid::dds
