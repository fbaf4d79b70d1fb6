// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/sink.hpp"

namespace stereogrid::messages {

Sink::~Sink() = default;

}  // namespace stereogrid::messages
