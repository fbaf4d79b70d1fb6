// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

namespace stereogrid::io {

inline constexpr const char* see_documentation{"docs/input.md shows what a calibration holds."};

/// Source of values, for messages: each is an InputError.
class Origin {
 public:
  /// `part`: of the file, "": all of it. `other_way`: sentence that every advice ends with; "": none.
  explicit Origin(std::string file, std::string part = "", std::string other_way = "")
      : file_{std::move(file)}, part_{std::move(part)}, other_way_{std::move(other_way)} {}

  [[nodiscard]] const std::string& file() const { return file_; }

  /// Names the part, too.
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(const std::string& what, const std::string& mend) const;

 protected:
  [[nodiscard]] const std::string& part() const { return part_; }
  /// Names the file only.
  [[noreturn]] void complain(const std::string& what) const;

 private:
  std::string file_;
  std::string part_;
  std::string other_way_;
};

}  // namespace stereogrid::io
