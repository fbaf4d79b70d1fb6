// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "../messages/random_filler.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

using namespace stereogrid::messages;

// Accepted messages are written and read back without a change.
template <Message M>
void read_and_write(std::span<const std::byte> cdr) {
  M message;
  if (!accepts([&] { decode(cdr, message); })) return;
  CdrWriter first;
  const auto written{first.encode(message)};
  M again;
  decode(written, again);
  CdrWriter second;
  require(std::ranges::equal(second.encode(again), written),
          "a message changes when it is written: " + std::string{M::type_name});
}

}  // namespace

/// A byte for the type, then a message.
FUZZ_TARGET(cdr) {
  if (input.empty()) return;
  const std::span<const std::byte> bytes{std::as_bytes(input.subspan(1))};
  int number{0};
  messages::test::for_each_type([&]<Message M>(const M& /*type*/) {
    if (number++ == input[0]) read_and_write<M>(bytes);
  });
}

}  // namespace stereogrid::fuzz
