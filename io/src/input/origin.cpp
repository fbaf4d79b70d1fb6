// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/origin.hpp"

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

constexpr std::size_t longest_finding{1000};  // it may quote the file

}  // namespace

void Origin::fail(const std::string& what) const {
  fail(what, see_documentation);
}

void Origin::fail(const std::string& what, const std::string& mend) const {
  throw InputError{part_.empty() ? file_ : file_ + " (" + printable(part_) + ")", printable(what, longest_finding),
                   other_way_.empty() ? mend : mend + " " + other_way_};
}

void Origin::complain(const std::string& what) const {
  throw InputError{file_, printable(what, longest_finding), see_documentation};
}

}  // namespace stereogrid::io
