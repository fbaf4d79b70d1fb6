// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Listens on a free port, and again on the same one, which is refused.
#include <stereogrid/error.hpp>
#include <stereogrid/server/server.hpp>

#include <cstdio>

using namespace stereogrid;

int main() {
  server::ServerOptions options;
  options.port = 0;
  const server::Server server{options};
  options.port = server.port();
  try {
    const server::Server another{options};
  } catch (const DeviceError& error) {  // across the library's border
    std::printf("%s\n", error.what());
    return 0;
  }
  return 1;
}
