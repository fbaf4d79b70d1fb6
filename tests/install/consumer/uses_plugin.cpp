// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include <cstdio>

int main(int, char** arguments) {
  void* const plugin{dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL)};
  void* const function{plugin == nullptr ? nullptr : dlsym(plugin, "plugin_works")};
  if (function == nullptr) {
    std::printf("%s\n", dlerror());
    return 1;
  }
  return reinterpret_cast<int (*)()>(function)() == 1 ? 0 : 1;
}
