// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

#include <memory>
#include <string>
#include <string_view>

#include "stereogrid/dds/node.hpp"

namespace stereogrid::dds {

struct FreeQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, FreeQos>;

struct FreeListener {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, FreeListener>;

/// Reliable, keeps the last `depth` messages. `is_transient_local`: late subscribers receive them, too.
[[nodiscard]] Qos reliable_qos(bool is_transient_local, int depth);
/// Matches every publisher.
[[nodiscard]] Qos best_effort_qos(int depth);
/// Sets the endpoint's user data, from which peers since Iron read the hash of its type. Humble ignores it.
void set_type_hash(dds_qos_t* qos, std::string_view ros_type, std::string_view definition);

/// Description of a policy for messages: "liveliness with a lease".
[[nodiscard]] std::string policy_in_words(std::uint32_t policy_id);

}  // namespace stereogrid::dds
