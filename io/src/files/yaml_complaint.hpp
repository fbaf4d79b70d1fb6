// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/exceptions.h>

#include <string>

namespace stereogrid::io {

/// Message for a YAML error of yaml-cpp.
inline std::string complaint_of(const YAML::Exception& error) {
  // its words for groups in groups beyond the depth that it can follow; of text in memory it says that of nothing else
  if (error.msg == "bad file") return "is nested too deeply.";
  return "is no YAML (" + error.msg + ").";
}

}  // namespace stereogrid::io
