// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "stereogrid/error.hpp"

namespace stereogrid::fuzz {
namespace {

/// Bytes of the character that begins `text`; 0: none does.
std::size_t character_size(std::string_view text) {
  const auto byte = [text](std::size_t i) { return i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0U; };
  const std::size_t size{byte(0) < 0x80 ? 1U : byte(0) < 0xc2 ? 0U : byte(0) < 0xe0 ? 2U : byte(0) < 0xf0 ? 3U : 4U};
  for (std::size_t i{1}; i < size; ++i) {
    if (byte(i) >> 6 != 2) return 0;
  }
  const bool overlong{(byte(0) == 0xe0 && byte(1) < 0xa0) || (byte(0) == 0xf0 && byte(1) < 0x90)};
  const bool surrogate{byte(0) == 0xed && byte(1) > 0x9f};
  const bool too_large{byte(0) > 0xf4 || (byte(0) == 0xf4 && byte(1) > 0x8f)};
  return overlong || surrogate || too_large ? 0 : size;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size{character_size(text)};
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

bool is_message_valid(const std::exception& error) {
  require(is_utf8(error.what()), std::string{"an error message that is not UTF-8: "} + error.what());
  return false;
}

}  // namespace

std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

void require(bool fine, const std::string& what) {
  if (!fine) throw Finding{what};
}

bool accepts(const std::function<void()>& work) {
  try {
    work();
    return true;
  } catch (const InputError& error) {
    return is_message_valid(error);
  } catch (const ConfigError& error) {
    return is_message_valid(error);
  } catch (const DeviceError& error) {
    return is_message_valid(error);
  }
}

std::string_view text_of(Bytes input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

std::vector<std::string_view> parts_of(Bytes input, std::size_t count) {
  constexpr std::string_view separator{"%%\n"};
  std::vector<std::string_view> parts(count);
  std::string_view text{text_of(input)};
  for (std::size_t i{0}; i < count; ++i) {
    parts[i] = i + 1 < count ? text.substr(0, text.find(separator)) : text;
    text.remove_prefix(std::min(parts[i].size() + separator.size(), text.size()));
  }
  return parts;
}

std::uint64_t Choices::word(std::size_t bytes) {
  std::uint64_t value{0};
  const std::size_t taken{std::min(bytes, rest_.size())};
  for (std::size_t i{0}; i < taken; ++i) value |= std::uint64_t{rest_[i]} << (8 * i);
  rest_ = rest_.subspan(taken);
  return value;
}

std::uint8_t Choices::byte() {
  return static_cast<std::uint8_t>(word(1));
}

int Choices::between(int least, int most) {
  const std::uint64_t count{static_cast<std::uint64_t>(std::int64_t{most} - least) + 1};
  return least + static_cast<int>(word(count <= 256 ? 1 : 4) % count);
}

double Choices::number(double least, double most) {
  const auto share{static_cast<double>(word(2)) / 65535};
  return share >= 1 ? most : least + share * (most - least);
}

std::int64_t Choices::any_integer() {
  using Limits = std::numeric_limits<std::int64_t>;
  static constexpr std::array<std::int64_t, 6> special{0, 1, -1, Limits::min(), Limits::max(), 100'000'000};
  return yes() ? one_of<std::int64_t>(special) : static_cast<std::int64_t>(word(8));
}

double Choices::any_number() {
  using Limits = std::numeric_limits<double>;
  static constexpr std::array<double, 14> special{0,
                                                  -0.0,
                                                  Limits::quiet_NaN(),
                                                  Limits::infinity(),
                                                  -Limits::infinity(),
                                                  Limits::max(),
                                                  Limits::lowest(),
                                                  1e38,
                                                  1e39,
                                                  Limits::min(),
                                                  1e-30,
                                                  1e9,
                                                  -1e9,
                                                  -1};
  return yes() ? one_of<double>(special) : std::bit_cast<double>(word(8));
}

}  // namespace stereogrid::fuzz
