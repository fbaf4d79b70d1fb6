// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#if __cplusplus < 202002L
#error \
    "stereogrid requires C++20: compile with -std=c++20, or in CMake target_compile_features(TARGET PRIVATE cxx_std_20)."
#endif

// Libraries are compiled with -fvisibility=hidden: a shared library exports only symbols with STEREOGRID_EXPORT.
// Classes that are thrown or derived from need it even if they are inline, as every library and program must use the
// same type. Static libraries use the same objects; their symbols stay hidden (see cmake/library.cmake).
#define STEREOGRID_EXPORT __attribute__((visibility("default")))

// Nested type that is not part of the interface of its class.
#define STEREOGRID_HIDDEN __attribute__((visibility("hidden")))
