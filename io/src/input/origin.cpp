// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/origin.hpp"

#include "stereogrid/error.hpp"

namespace stereogrid::io {

void Origin::fail(const std::string& what) const {
  fail(what, see_documentation);
}

void Origin::fail(const std::string& what, const std::string& mend) const {
  throw InputError{part_.empty() ? file_ : file_ + " (" + part_ + ")", what,
                   other_way_.empty() ? mend : mend + " " + other_way_};
}

void Origin::complain(const std::string& what) const {
  throw InputError{file_, what, see_documentation};
}

}  // namespace stereogrid::io
