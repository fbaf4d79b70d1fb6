// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "counters.hpp"
#include "foxglove/hub.hpp"
#include "http/site.hpp"

namespace stereogrid::server {

class Session;

/// What all sessions share, on the server's thread.
struct Surroundings {
  Hub& hub;
  const Site& site;
  const Limits& limits;
  Counters& counters;
  std::set<Session*> sessions{};
  std::function<void()> emptied{};  ///< called when the last session has gone
};

/// A client's connection, from its acceptance to its end; it lives as long as something of it is under way.
class Session : public std::enable_shared_from_this<Session> {
 public:
  explicit Session(Surroundings& around) : around_{around} { around_.sessions.insert(this); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual ~Session() {
    around_.sessions.erase(this);
    if (around_.sessions.empty() && around_.emptied) around_.emptied();
  }

  /// Ends it politely; and at once.
  virtual void stop() = 0;
  virtual void cut() = 0;

 protected:
  Surroundings& around_;
};

}  // namespace stereogrid::server
