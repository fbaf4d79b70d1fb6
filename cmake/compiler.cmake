# SPDX-License-Identifier: Apache-2.0
#
# One place for compiler settings: link a target to stereogrid_compiler to get them.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
if(PROJECT_IS_TOP_LEVEL)
  if(NOT DEFINED CMAKE_CXX_FLAGS_RELWITHDEBINFO OR CMAKE_CXX_FLAGS_RELWITHDEBINFO STREQUAL "-O2 -g -DNDEBUG")
    set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O3 -g1 -DNDEBUG")
  endif()
  find_program(STEREOGRID_CCACHE ccache)
  if(STEREOGRID_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${STEREOGRID_CCACHE})
  endif()
endif()

add_library(stereogrid_compiler INTERFACE)
target_compile_options(
  stereogrid_compiler
  INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wall
            -Wextra
            -Wpedantic
            -Wshadow
            -Wconversion
            -Wno-sign-conversion
            -Wnon-virtual-dtor
            # g++ 12 sees overlaps in std::string's operator+ that are not there
            $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict>
            # scalar, vectorised and GPU code must round alike
            -ffp-contract=off>)
if(STEREOGRID_WERROR)
  target_compile_options(stereogrid_compiler INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
endif()
if(STEREOGRID_HARDENING
   AND PROJECT_IS_TOP_LEVEL
   AND CMAKE_BUILD_TYPE MATCHES "^Rel"
   AND NOT STEREOGRID_SANITIZE)
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fstack-protector-strong>
                      "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2>"
                      $<$<COMPILE_LANGUAGE:CXX>:-ffile-prefix-map=${PROJECT_SOURCE_DIR}=.>)
  add_link_options(LINKER:-z,relro,-z,now)
endif()
if(STEREOGRID_SANITIZE)
  add_compile_options(-fsanitize=${STEREOGRID_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${STEREOGRID_SANITIZE})
  # with sanitizers g++ sees these in the standard library's <regex>, where there are none
  target_compile_options(stereogrid_compiler INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>)
endif()
if(STEREOGRID_SANITIZE MATCHES thread)
  # in place of oneTBB's headers, which hide their synchronisation from the sanitizer
  foreach(header blocked_range info parallel_for task_arena)
    foreach(folder tbb oneapi/tbb)
      configure_file(${PROJECT_SOURCE_DIR}/tests/tbb.hpp ${PROJECT_BINARY_DIR}/tsan/${folder}/${header}.h COPYONLY)
    endforeach()
  endforeach()
  include_directories(BEFORE ${PROJECT_BINARY_DIR}/tsan)
endif()
if(STEREOGRID_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang" OR NOT STEREOGRID_TOOL)
    message(FATAL_ERROR "STEREOGRID_FUZZ needs clang++ (cmake --preset fuzz) and STEREOGRID_TOOL=ON")
  endif()
  # coverage in the libraries; the fuzzers themselves link libFuzzer and its main()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# stereogrid_unity(TARGET [FILE…]): with STEREOGRID_UNITY the target's files are compiled together, but for the FILEs,
# which define names that others define, too.
function(stereogrid_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${STEREOGRID_UNITY})
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
