// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "evaluation_output.hpp"
#include "stereogrid/io/file.hpp"

namespace stereogrid::app {

void write_report(const std::filesystem::path& path, const nlohmann::ordered_json& evaluation) {
  io::write_file(path, evaluation.dump());
}

}  // namespace stereogrid::app
