// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/sha256.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace stereogrid::app::batch {
namespace {

// FIPS 180-4, 4.2.2: of the cube roots of the first 64 primes
constexpr std::array<std::uint32_t, 64> round_constants{
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

using Schedule = std::array<std::uint32_t, 64>;

Schedule schedule_of(const unsigned char* block) {
  Schedule w{};
  for (std::size_t t{0}; t < 16; ++t) {
    w[t] = std::uint32_t{block[4 * t]} << 24 | std::uint32_t{block[4 * t + 1]} << 16 |
           std::uint32_t{block[4 * t + 2]} << 8 | std::uint32_t{block[4 * t + 3]};
  }
  for (std::size_t t{16}; t < 64; ++t) {
    const std::uint32_t s0{std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ (w[t - 15] >> 3)};
    const std::uint32_t s1{std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ (w[t - 2] >> 10)};
    w[t] = s1 + w[t - 7] + s0 + w[t - 16];
  }
  return w;
}

}  // namespace

void Sha256::take_block(const unsigned char* block) {
  const Schedule w{schedule_of(block)};
  auto [a, b, c, d, e, f, g, h]{state_};
  for (std::size_t t{0}; t < 64; ++t) {
    const std::uint32_t s1{std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)};
    const std::uint32_t t1{h + s1 + ((e & f) ^ (~e & g)) + round_constants[t] + w[t]};
    const std::uint32_t s0{std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)};
    const std::uint32_t t2{s0 + ((a & b) ^ (a & c) ^ (b & c))};
    h = g;
    g = f;
    f = e;
    e = d + t1;
    d = c;
    c = b;
    b = a;
    a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> added{a, b, c, d, e, f, g, h};
  for (std::size_t i{0}; i < 8; ++i) state_[i] += added[i];
}

void Sha256::add(std::string_view bytes) {
  bytes_ += bytes.size();
  if (waiting_bytes_ > 0) {
    const std::size_t count{std::min(bytes.size(), waiting_.size() - waiting_bytes_)};
    std::memcpy(waiting_.data() + waiting_bytes_, bytes.data(), count);
    waiting_bytes_ += count;
    bytes.remove_prefix(count);
    if (waiting_bytes_ < waiting_.size()) return;
    take_block(waiting_.data());
    waiting_bytes_ = 0;
  }
  for (; bytes.size() >= waiting_.size(); bytes.remove_prefix(waiting_.size())) {
    take_block(reinterpret_cast<const unsigned char*>(bytes.data()));
  }
  if (!bytes.empty()) std::memcpy(waiting_.data(), bytes.data(), bytes.size());
  waiting_bytes_ = bytes.size();
}

std::string Sha256::hex() {
  const std::uint64_t bits{bytes_ * 8};
  std::string padding(1, '\x80');
  padding.append((119 - waiting_bytes_) % 64, '\0');
  for (int shift{56}; shift >= 0; shift -= 8) padding += static_cast<char>(bits >> shift & 0xff);
  add(padding);
  std::string digits;
  for (const std::uint32_t word : state_) digits += fmt::format("{:08x}", word);
  return digits;
}

std::string sha256_of(std::string_view bytes) {
  Sha256 digest;
  digest.add(bytes);
  return digest.hex();
}

}  // namespace stereogrid::app::batch
