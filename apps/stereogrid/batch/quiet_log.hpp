// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <spdlog/spdlog.h>

namespace stereogrid::app::batch {

/// While it lives, the log has warnings only: a thousand runners would fill it.
class QuietLog {
 public:
  QuietLog() : before_{spdlog::get_level()} {
    if (before_ == spdlog::level::info) spdlog::set_level(spdlog::level::warn);
  }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;
  ~QuietLog() { spdlog::set_level(before_); }

 private:
  spdlog::level::level_enum before_;
};

}  // namespace stereogrid::app::batch
