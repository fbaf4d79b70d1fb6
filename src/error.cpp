// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/error.hpp"

#include <cstddef>

#include "stereogrid/printable.hpp"

namespace stereogrid {
namespace {

constexpr std::size_t longest_message{16'384};
constexpr std::size_t longest_finding{2'000};  // names of files are never shortened, quoted lines are

}  // namespace

ConfigError::ConfigError(const std::string& message) : std::runtime_error{printable_lines(message, longest_message)} {}

InputError::InputError(const std::string& message) : std::runtime_error{printable_lines(message, longest_message)} {}

InputError::InputError(const std::string& file, const std::string& what_is_wrong, const std::string& what_would_mend_it)
    : std::runtime_error{printable(file, longest_message) + ": " + printable(what_is_wrong, longest_finding) + " " +
                         printable(what_would_mend_it, longest_finding)} {}

DeviceError::DeviceError(const std::string& message) : std::runtime_error{printable_lines(message, longest_message)} {}

}  // namespace stereogrid
