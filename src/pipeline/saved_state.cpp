// SPDX-License-Identifier: Apache-2.0
#include "pipeline/saved_state.hpp"

#include <algorithm>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr std::uint64_t prime{0x100000001b3};

struct Head {
  std::array<char, 8> kind{'S', 'G', 's', 't', 'a', 't', 'e', '2'};
  std::uint64_t settings{0};
  std::uint64_t size{0};  ///< size of the rest, bytes
  std::uint64_t checksum{0};
};

void require(bool fine, const char* problem) {
  if (!fine) throw InputError{"saved state", problem, "Begin without it."};
}

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

std::vector<std::byte> sealed(std::span<const std::byte> state, std::uint64_t settings) {
  const Head head{.settings = settings, .size = state.size(), .checksum = checksum_of(state)};
  std::vector<std::byte> saved(sizeof(head) + state.size());
  std::memcpy(saved.data(), &head, sizeof(head));
  std::copy(state.begin(), state.end(), saved.begin() + sizeof(head));
  return saved;
}

std::span<const std::byte> unsealed(std::span<const std::byte> saved, std::uint64_t settings) {
  Head head;
  require(saved.size() >= sizeof(head) && std::memcmp(saved.data(), &head, sizeof(head.kind)) == 0,
          "is none of a pipeline of this version.");
  std::memcpy(&head, saved.data(), sizeof(head));
  const auto state{saved.subspan(sizeof(head))};
  require(head.settings == settings, "belongs to another configuration, rig, back end or version.");
  require(head.size == state.size() && head.checksum == checksum_of(state), "is damaged.");
  return state;
}

}  // namespace stereogrid
