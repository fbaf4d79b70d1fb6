// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <type_traits>

namespace stereogrid {

/// Bytes that a part's buffers hold, the part itself not among them: of a structure what its memory_bytes() says, of a
/// vector its room and what its elements hold, of an image its elements. Who adds a buffer to a structure adds it to
/// its memory_bytes(); a test compares the sum with malloc (tests/core/memory/allocation_test.cpp).
template <class Part>
std::size_t memory_bytes(const Part& part) {
  using Element = std::remove_cvref_t<decltype(*part.data())>;
  if constexpr (requires { part.capacity(); }) {
    std::size_t bytes{part.capacity() * sizeof(Element)};
    if constexpr (!std::is_trivially_destructible_v<Element>) {
      for (const Element& element : part) bytes += memory_bytes(element);
    }
    return bytes;
  } else {
    return part.size() * sizeof(Element);
  }
}
template <class Part>
requires requires(const Part& part) {
  part.memory_bytes();
}
std::size_t memory_bytes(const Part& part) {
  return part.memory_bytes();
}

template <class... Parts>
std::size_t memory_bytes_of(const Parts&... parts) {
  return (memory_bytes(parts) + ...);
}

}  // namespace stereogrid
