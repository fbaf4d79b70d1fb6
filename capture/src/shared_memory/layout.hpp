// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace stereogrid::capture {

// Little-endian, as all machines are that this is made for. docs/live.md tells writers the same.

/// At the beginning. `written`: number of the newest pair, from 1; 0: none yet. Pair n is in slot (n − 1) % slots.
struct SharedHeader {
  std::array<char, 8> magic{'S', 'G', 'P', 'A', 'I', 'R', '0', '1'};
  std::uint32_t width_px{0};
  std::uint32_t height_px{0};
  std::uint32_t slots{0};
  std::uint32_t reserved{0};
  std::uint64_t written{0};
  std::array<std::uint64_t, 4> padding{};
};

/// Before the images of each slot: left, then right, width × height bytes each. The writer sets `begun` to the pair's
/// number before it touches them and `finished` after that.
struct SharedSlot {
  std::uint64_t begun{0};
  std::uint64_t finished{0};
  std::int64_t captured_ns{0};  ///< CLOCK_MONOTONIC; 0: when it is read
  std::array<std::uint64_t, 5> padding{};
};

static_assert(sizeof(SharedHeader) == 64 && sizeof(SharedSlot) == 64);

constexpr std::uint32_t shared_slots_max{64};
constexpr std::uint32_t shared_side_max_px{1u << 14};

/// Of a slot with its images, in whole cache lines.
[[nodiscard]] constexpr std::size_t slot_bytes(std::size_t width_px, std::size_t height_px) {
  return sizeof(SharedSlot) + (2 * width_px * height_px + 63) / 64 * 64;
}

/// "/stereo" of "stereo" or "/stereo". Throws ConfigError: no name of shared memory.
[[nodiscard]] std::string shared_name(const std::string& given);

}  // namespace stereogrid::capture
