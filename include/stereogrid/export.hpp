// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The libraries are compiled with -fvisibility=hidden: a shared library shows what carries STEREOGRID_EXPORT and
// nothing else. Classes that are thrown or derived from carry it even if all they have is inline: every library and
// program must mean the same type. The same objects serve static libraries, whose symbols nobody shows again (see
// cmake/library.cmake).
#define STEREOGRID_EXPORT __attribute__((visibility("default")))

// A nested type that is no part of the interface of the class around it.
#define STEREOGRID_HIDDEN __attribute__((visibility("hidden")))
