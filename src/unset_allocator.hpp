// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <new>
#include <utility>

namespace stereogrid {

/// Leaves numbers without a given value unset, so that memory that is never written takes no time and no pages.
template <class Number>
struct UnsetAllocator : std::allocator<Number> {
  template <class Other>
  struct rebind {
    using other = UnsetAllocator<Other>;
  };

  template <class Other, class... Values>
  void construct(Other* place, Values&&... values) {
    if constexpr (sizeof...(values) == 0) {
      ::new (static_cast<void*>(place)) Other;
    } else {
      ::new (static_cast<void*>(place)) Other(std::forward<Values>(values)...);
    }
  }
};

}  // namespace stereogrid
