// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

namespace stereogrid::fuzz {
void STEREOGRID_FUZZ_TARGET(Bytes input);
}

// An exception that leaves it is a finding to libFuzzer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  stereogrid::fuzz::STEREOGRID_FUZZ_TARGET({data, size});
  return 0;
}
