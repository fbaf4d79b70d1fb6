// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda_library.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr const char* file_name{"libstereogrid_cuda.so"};
constexpr const char* variable{"STEREOGRID_CUDA_LIBRARY"};

// Of the program, or of the shared library, that this function was linked into.
std::filesystem::path own_folder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&own_folder), &info) == 0 || info.dli_fname == nullptr) return {};
  std::error_code error;
  return std::filesystem::canonical(info.dli_fname, error).parent_path();
}

void* opened(const std::string& name) {
  void* const library{dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)};
  if (library == nullptr) {
    const char* const complaint{dlerror()};
    throw DeviceError{"The CUDA library " + name + " could not be loaded: " + (complaint == nullptr ? "" : complaint) +
                      "."};
  }
  return library;
}

void* found_and_opened() {
  if (const char* const named{std::getenv(variable)}; named != nullptr && *named != '\0') return opened(named);
  const std::filesystem::path folder{own_folder()};
  for (const std::filesystem::path& candidate :
       {folder / file_name, folder / ".." / STEREOGRID_LIBRARY_FOLDER / file_name}) {
    std::error_code error;
    if (!folder.empty() && std::filesystem::exists(candidate, error)) return opened(candidate.string());
  }
  if (void* const library{dlopen(file_name, RTLD_NOW | RTLD_LOCAL)}; library != nullptr) return library;
  throw DeviceError{std::string{file_name} + " was not found, neither beside the program nor where libraries are. " +
                    "stereogrid was built without CUDA, or that file was not installed (docs/gpu.md)."};
}

const CudaLibrary& load() {
  void* const library{found_and_opened()};
  const auto function{reinterpret_cast<const CudaLibrary* (*)()>(dlsym(library, cuda_library_function))};
  if (function == nullptr) {
    throw DeviceError{std::string{file_name} + " is of another version: it has no function " + cuda_library_function +
                      ". Install the one that belongs to stereogrid " + std::string{version()} + "."};
  }
  const CudaLibrary& found{*function()};
  if (found.version != version() || found.sizes != interface_sizes()) {
    throw DeviceError{std::string{file_name} + " belongs to stereogrid " + found.version +
                      ", or was built otherwise; " + "this is " + std::string{version()} +
                      ". Install both from the same build."};
  }
  return found;
}

}  // namespace

std::unique_ptr<Journey> cuda_journey(const Config& config, const Rig& rig) {
  return load().journey(config, rig);  // it stays loaded
}

}  // namespace stereogrid
