// SPDX-License-Identifier: Apache-2.0
//
// Functions of Highway's compiled part for the tests, for a machine with one instruction set (scripts/check-neon.sh).
#include <hwy/targets.h>

namespace hwy {

std::int64_t SupportedTargets() {
  return HWY_STATIC_TARGET;
}

void SetSupportedTargetsForTest(std::int64_t) {}

ChosenTarget& GetChosenTarget() {
  static ChosenTarget chosen;
  return chosen;
}

}  // namespace hwy
