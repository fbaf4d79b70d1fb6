// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "stereogrid/error.hpp"

// Tests of the CUDA back end, without GoogleTest: a machine with a GPU may have nothing but nvcc and CMake.
//
//   TEST(name) { CHECK(a == b); CHECK_EQUAL(a, b); CHECK_NEAR(a, b, 1e-6); }
//
// tests/cuda/main.cu runs them all, or those whose name contains the first argument.

namespace stereogrid::test {

struct CudaTest {
  const char* name;
  void (*body)();
};

inline std::vector<CudaTest>& cuda_tests() {
  static std::vector<CudaTest> tests;
  return tests;
}

inline int failures{0};

struct AddTest {
  AddTest(const char* name, void (*body)()) { cuda_tests().push_back({name, body}); }
};

/// Only the first few are printed.
inline void fail(const char* file, int line, const std::string& what) {
  if (++failures <= 20) std::printf("%s:%d: %s\n", file, line, what.c_str());
}

template <class A, class B>
std::string text_of(const char* expression, const A& a, const B& b) {
  std::ostringstream text;
  text.precision(9);
  text << expression << ": " << a << " and " << b;
  return text.str();
}

/// Message of the exception of `body`; "" without one.
inline std::string error_text_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

}  // namespace stereogrid::test

#define TEST(name)                                                         \
  static void test_##name();                                               \
  static const ::stereogrid::test::AddTest add_##name{#name, test_##name}; \
  static void test_##name()
#define CHECK(condition) ((condition) ? void() : ::stereogrid::test::fail(__FILE__, __LINE__, #condition))
#define CHECK_EQUAL(a, b) \
  ((a) == (b) ? void()    \
              : ::stereogrid::test::fail(__FILE__, __LINE__, ::stereogrid::test::text_of(#a " == " #b, (a), (b))))
#define CHECK_NEAR(a, b, bound)                 \
  ((a) - (b) <= (bound) && (b) - (a) <= (bound) \
       ? void()                                 \
       : ::stereogrid::test::fail(__FILE__, __LINE__, ::stereogrid::test::text_of(#a " near " #b, (a), (b))))
