// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "saved_state.hpp"

namespace stereogrid {
namespace {

constexpr std::uint64_t prime{0x100000001b3};

}  // namespace

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  std::uint64_t sum{0xcbf29ce484222325};
  std::uint64_t word{0};
  for (; bytes.size() >= sizeof(word); bytes = bytes.subspan(sizeof(word))) {
    std::memcpy(&word, bytes.data(), sizeof(word));
    sum = (sum ^ word) * prime;
    sum ^= sum >> 32;  // a product's low bits do not depend on the word's high ones
  }
  for (const std::byte byte : bytes) sum = (sum ^ std::to_integer<std::uint64_t>(byte)) * prime;
  return sum;
}

}  // namespace stereogrid
