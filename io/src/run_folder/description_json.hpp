// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "stereogrid/io/run_folder/description.hpp"

namespace stereogrid::io {

/// Beginning of run.json: settings that a resumed run must share.
[[nodiscard]] nlohmann::ordered_json settings_json(const RunDescription& run);

[[nodiscard]] nlohmann::ordered_json rig_json(const Rig& rig);

/// Reads what settings_json writes under "input". Throws the JSON library's exceptions, and InputError without file.
[[nodiscard]] RunInput run_input_of(const nlohmann::ordered_json& input);

}  // namespace stereogrid::io
