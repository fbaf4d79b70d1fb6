// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/planned_input.hpp"

#include <filesystem>
#include <system_error>

#include "batch/input_digest.hpp"
#include "batch/run_options.hpp"
#include "batch/transfer.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app::batch {

std::string PlannedInput::missing() const {
  namespace fs = std::filesystem;
  std::error_code error;
  for (const std::string& path : shard_.input) {
    if (path.starts_with("scene:") || (transfer_ != nullptr && transfer_->fetches(path))) continue;
    const bool is_empty{fs::is_directory(path, error) && fs::is_empty(path, error)};
    if (is_empty || !fs::exists(path, error)) return io::printable(path);
  }
  return "";
}

void PlannedInput::fetch() {
  if (transfer_ == nullptr) return;
  const auto wrong = [this](const auto& copies) -> std::string {
    try {
      return is_as_planned(copies) ? "" : "what came is not what the plan was made of: another checksum";
    } catch (const DeviceError& error) {
      return error.what();
    }
  };
  copies_ = transfer_->fetch(files_of(run_options(plan_.plan(), shard_, {}, {}).input), wrong);
}

bool PlannedInput::is_there() const {
  try {
    return missing().empty() && is_as_planned();
  } catch (const DeviceError&) {
    return false;
  }
}

bool PlannedInput::is_as_planned(const std::map<std::string, std::string>& copies) const {
  const DigestOf what{plan_.plan().content_digests ? DigestOf::content : DigestOf::names_and_sizes};
  try {
    return digest_of_input(run_options(plan_.plan(), shard_, {}, copies).input, what) == shard_.input_digest;
  } catch (const InputError& error) {
    throw DeviceError{error.what()};
  }
}

}  // namespace stereogrid::app::batch
