// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "shared_memory/layout.hpp"

#include "stereogrid/error.hpp"

namespace stereogrid::capture {

std::string shared_name(const std::string& given) {
  const std::string bare{given.starts_with('/') ? given.substr(1) : given};
  if (bare.empty() || bare.size() > 250 || bare.find('/') != std::string::npos ||
      bare.find('\0') != std::string::npos) {
    throw ConfigError{"shm:" + given + ": no name of shared memory. Give one such as shm:/stereo."};
  }
  return "/" + bare;
}

}  // namespace stereogrid::capture
