// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstring>

#include "backend/cuda.hpp"
#include "check.hpp"

// Arguments: part of the names of the tests to run; none: all. Exit status 0: passed, 1: failed, 77: no device.
int main(int count, char** arguments) {
  using namespace stereogrid;
  try {
    const Cuda probe;
  } catch (const DeviceError& error) {
    std::printf("SKIPPED, nothing was tested: %s\n", error.what());
    return 77;
  }
  int run{0};
  for (const test::CudaTest& one : test::cuda_tests()) {
    if (count > 1 && std::strstr(one.name, arguments[1]) == nullptr) continue;
    const int before{test::failures};
    try {
      one.body();
    } catch (const std::exception& error) {
      test::fail(one.name, 0, error.what());
    }
    std::printf("%-6s %s\n", test::failures == before ? "ok" : "FAILED", one.name);
    std::fflush(stdout);
    ++run;
  }
  std::printf("%d tests, %d failures\n", run, test::failures);
  return run > 0 && test::failures == 0 ? 0 : 1;
}
