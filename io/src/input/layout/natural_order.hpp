// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cctype>
#include <string_view>

namespace stereogrid::io {

/// Sorts names as people do: frame_9 before frame_10.
struct NaturalOrder {
  [[nodiscard]] bool operator()(std::string_view a, std::string_view b) const {
    const std::string_view whole_a{a};
    const std::string_view whole_b{b};
    while (!a.empty() && !b.empty()) {
      const std::string_view number_a{digits_of(a)};
      const std::string_view number_b{digits_of(b)};
      if (number_a.empty() || number_b.empty()) {
        if (a[0] != b[0]) return a[0] < b[0];
        a.remove_prefix(1);
        b.remove_prefix(1);
        continue;
      }
      const std::string_view value_a{without_zeros(number_a)};
      const std::string_view value_b{without_zeros(number_b)};
      if (value_a.size() != value_b.size()) return value_a.size() < value_b.size();
      if (value_a != value_b) return value_a < value_b;
      a.remove_prefix(number_a.size());
      b.remove_prefix(number_b.size());
    }
    if (a.empty() != b.empty()) return a.empty();
    return whole_a < whole_b;  // 01 and 1 are two names
  }

 private:
  static std::string_view digits_of(std::string_view text) {
    std::size_t count{0};
    while (count < text.size() && std::isdigit(static_cast<unsigned char>(text[count])) != 0) ++count;
    return text.substr(0, count);
  }

  static std::string_view without_zeros(std::string_view digits) {
    const std::size_t first{digits.find_first_not_of('0')};
    return first == std::string_view::npos ? std::string_view{} : digits.substr(first);
  }
};

}  // namespace stereogrid::io
