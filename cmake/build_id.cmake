# SPDX-License-Identifier: Apache-2.0
#
# cmake -D VERSION=… -D ROOT=… -D OUTPUT=… -P build_id.cmake
# Writes the source file of version() and build_id(): VERSION, and a hash of the names and contents of ROOT's core sources.
cmake_minimum_required(VERSION 3.22)

file(
  GLOB_RECURSE sources
  RELATIVE ${ROOT}
  ${ROOT}/include/*.hpp ${ROOT}/src/*.hpp ${ROOT}/src/*.cpp ${ROOT}/src/*.cu)
list(SORT sources)
set(contents)
foreach(source IN LISTS sources)
  file(SHA256 ${ROOT}/${source} hash)
  string(APPEND contents "${source} ${hash}\n")
endforeach()
string(SHA256 hash "${contents}")
string(SUBSTRING ${hash} 0 16 hash)

file(WRITE ${OUTPUT} "// Made by cmake/build_id.cmake.
#include \"pipeline/cuda_library.hpp\"
#include \"stereogrid/pipeline.hpp\"

namespace stereogrid {

std::string_view version() {
  return \"${VERSION}\";
}

std::string_view build_id() {
  return \"${VERSION}+${hash}\";
}

}  // namespace stereogrid
")
