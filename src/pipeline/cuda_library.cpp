// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cuda_library.hpp"

#include <dlfcn.h>
#include <sys/auxv.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr const char* file_name{"libstereogrid_cuda.so"};
constexpr const char* variable{"STEREOGRID_CUDA_LIBRARY"};

// Folder of the program or shared library that contains this function; empty: unknown. A program's own name is as typed
// by the user: found through PATH it has no folder, and would be searched in the current one.
std::filesystem::path own_folder() {
  Dl_info own{};
  if (dladdr(reinterpret_cast<const void*>(&own_folder), &own) == 0 || own.dli_fname == nullptr) return {};
  Dl_info program{};
  const auto* const in_program{reinterpret_cast<const void*>(getauxval(AT_PHDR))};
  const bool is_program{dladdr(in_program, &program) != 0 && program.dli_fbase == own.dli_fbase};
  std::error_code error;
  const std::filesystem::path file{is_program ? std::filesystem::read_symlink("/proc/self/exe", error)
                                              : std::filesystem::path{own.dli_fname}};
  if (!file.is_absolute()) return {};
  return std::filesystem::canonical(file.parent_path(), error);
}

void* opened(const std::string& name) {
  void* const library{dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)};
  if (library == nullptr) {
    const char* const problem{dlerror()};
    throw DeviceError{"The CUDA library " + name + " could not be loaded: " + (problem == nullptr ? "" : problem) +
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

std::string path_of(const void* loaded) {
  Dl_info info{};
  return dladdr(loaded, &info) != 0 && info.dli_fname != nullptr ? info.dli_fname : file_name;
}

const CudaLibrary& load() {
  void* const library{found_and_opened()};
  void* const symbol{dlsym(library, cuda_library_function)};
  const std::string mine{build_id()};
  if (symbol == nullptr) {
    throw DeviceError{std::string{"The CUDA library is of another version: it has no function "} +
                      cuda_library_function + ". Install the one that belongs to stereogrid " + mine + "."};
  }
  const CudaLibrary& found{*reinterpret_cast<const CudaLibrary* (*)()>(symbol)()};
  if (found.build != mine) {
    throw DeviceError{"The CUDA library " + path_of(symbol) + " belongs to stereogrid " + found.build + "; this is " +
                      mine + ". Install both from the same build."};
  }
  if (found.sizes != interface_sizes()) {
    throw DeviceError{"The CUDA library " + path_of(symbol) + " belongs to stereogrid " + mine +
                      " as this does, but was built otherwise: its structures have other sizes. " +
                      "Build both with the same compiler and options."};
  }
  return found;
}

}  // namespace

std::unique_ptr<Stages> cuda_stages(const Config& config, const Rig& level_rig, int device,
                                    const StagesOptions& options) {
  return load().stages(config, level_rig, device, options);  // it stays loaded
}

}  // namespace stereogrid
