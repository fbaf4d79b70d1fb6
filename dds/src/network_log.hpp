// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace stereogrid::dds {

/// What Cyclone DDS complains of goes there from now on, in this process: each sentence once, as with a cable that is
/// pulled it says the same of every packet. Numbers make no other sentence.
void take_network_log(std::function<void(const std::string&)> warn);

}  // namespace stereogrid::dds
