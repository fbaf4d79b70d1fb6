// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "outlet.hpp"

#include <algorithm>

#include "stereogrid/error.hpp"

namespace stereogrid::messages {

bool Outlet::select(std::string_view name) {
  if (std::ranges::find(known_, name) == known_.end()) known_.emplace_back(name);
  return selected_.empty() || std::ranges::find(selected_, name) != selected_.end();
}

void Outlet::check_selection() const {
  for (const std::string& name : selected_) {
    if (std::ranges::find(known_, name) != known_.end()) continue;
    std::string text{"There is no topic \"" + name + "\". There are:"};
    for (const std::string& known : known_) text += " " + known;
    throw ConfigError{text};
  }
}

}  // namespace stereogrid::messages
