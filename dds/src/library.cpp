// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "network_log.hpp"
#include "network_node.hpp"
#include "stereogrid/dds/node.hpp"

namespace stereogrid::dds {
namespace {

void check(const NodeOptions& options) {
  const Names names{options};
  static_cast<void>(network_of_environment());
}

std::unique_ptr<Node> open(const NodeOptions& options) {
  take_network_log(options.warn);
  return std::make_unique<NetworkNode>(options);
}

}  // namespace
}  // namespace stereogrid::dds

extern "C" STEREOGRID_EXPORT const stereogrid::dds::Library* stereogrid_dds_library_4();

const stereogrid::dds::Library* stereogrid_dds_library_4() {
  using namespace stereogrid::dds;
  static const Library library{STEREOGRID_VERSION, interface_sizes(), check, open};
  return &library;
}
