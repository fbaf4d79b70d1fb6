// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "../temporary_folder.hpp"

namespace stereogrid::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A fuzz target: accepts any bytes, and throws or crashes on a fault.
struct Target {
  const char* name;
  void (*run)(Bytes input);
};
/// All targets that are linked.
[[nodiscard]] std::vector<Target>& targets();

/// Something happened that no input may cause.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws Finding(`what`) unless `fine`.
void require(bool fine, const std::string& what);

/// Runs `work`. False: it complained as it may (InputError, ConfigError, DeviceError), in UTF-8. Other exceptions pass.
bool accepts(const std::function<void()>& work);

/// An input as text.
[[nodiscard]] std::string_view text_of(Bytes input);

/// An input that stands for several files: `count` parts, separated by lines of "%%"; missing ones are empty.
[[nodiscard]] std::vector<std::string_view> parts_of(Bytes input, std::size_t count);

using Folder = tests::TemporaryFolder;

/// Takes an input for decisions, from its beginning; at its end all are the first or smallest ones.
class Choices {
 public:
  explicit Choices(Bytes input) : rest_{input} {}

  bool yes() { return (byte() & 1) != 0; }
  /// Once in `count` times, where bytes are random; never at the end of the input.
  bool once_in(int count) { return byte() % count == count - 1; }
  std::uint8_t byte();
  int between(int least, int most);
  /// Number in that range, often one of its ends.
  double number(double least, double most);
  std::int64_t any_integer();
  /// Also not finite, denormal, huge.
  double any_number();
  template <class T>
  const T& one_of(std::span<const T> values) {
    return values[static_cast<std::size_t>(between(0, static_cast<int>(values.size()) - 1))];
  }

 private:
  std::uint64_t word(std::size_t bytes);

  Bytes rest_;
};

}  // namespace stereogrid::fuzz

/// Begins the definition of a target: FUZZ_TARGET(npy) { … `input` … }. A fuzzer is made of each (CMakeLists.txt lists
/// them, too), and the replay runs it on the stored inputs.
#define FUZZ_TARGET(name)                                                                         \
  void name(Bytes input);                                                                         \
  [[maybe_unused]] static const bool name##_is_added{(targets().push_back({#name, name}), true)}; \
  void name(Bytes input)
