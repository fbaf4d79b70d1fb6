# SPDX-License-Identifier: Apache-2.0
#
# Common properties of the libraries: shared or static according to BUILD_SHARED_LIBS, visible symbols only with
# STEREOGRID_EXPORT. Shared and static libraries use the same objects.

# stereogrid_public_library(TARGET NAME): TARGET becomes stereogrid::NAME, in the tree as in the package. TARGET_internals
# is for tests, benchmarks and the CUDA library, which use functions that a shared library hides.
function(stereogrid_public_library target name)
  add_library(stereogrid::${name} ALIAS ${target})
  # before 1.0 a minor version may break programs, so that the name that they look for (SONAME) has it
  set_target_properties(
    ${target}
    PROPERTIES EXPORT_NAME ${name}
               VERSION ${PROJECT_VERSION}
               SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
               DEFINE_SYMBOL ""
               CXX_VISIBILITY_PRESET hidden
               VISIBILITY_INLINES_HIDDEN ON
               LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin # folder in which the tool finds libstereogrid_cuda.so
               INSTALL_RPATH "$ORIGIN")
  if(STEREOGRID_SANITIZE) # users need the sanitizer's library
    target_link_options(${target} INTERFACE -fsanitize=${STEREOGRID_SANITIZE})
  endif()

  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    # symbols stay hidden within a plugin
    target_link_options(${target} INTERFACE LINKER:--exclude-libs,$<TARGET_FILE_NAME:stereogrid::${name}>)
    add_library(${target}_internals ALIAS ${target})
  else()
    add_library(${target}_internals STATIC EXCLUDE_FROM_ALL $<TARGET_OBJECTS:${target}>)
    set_target_properties(${target}_internals PROPERTIES LINKER_LANGUAGE CXX)
    target_include_directories(${target}_internals
                               INTERFACE $<TARGET_PROPERTY:${target},INTERFACE_INCLUDE_DIRECTORIES>)
    target_link_libraries(${target}_internals PUBLIC $<GENEX_EVAL:$<TARGET_PROPERTY:${target},LINK_LIBRARIES>>)
  endif()
endfunction()

# stereogrid_library(NAME [FILE…]): stereogrid_NAME of the files in NAME/src/, with the headers in NAME/include/. FILEs of
# the folder are compiled alone (stereogrid_unity).
function(stereogrid_library name)
  set(target stereogrid_${name})
  set(folder ${PROJECT_SOURCE_DIR}/${name})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${folder}/src/*.cpp)
  add_library(${target} ${sources})
  list(TRANSFORM ARGN PREPEND ${folder}/ OUTPUT_VARIABLE alone)
  stereogrid_unity(${target} ${alone})
  stereogrid_public_library(${target} ${name})
  target_include_directories(
    ${target}
    PUBLIC $<BUILD_INTERFACE:${folder}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${folder}/src)
  target_link_libraries(${target} PUBLIC stereogrid PRIVATE $<BUILD_INTERFACE:stereogrid_compiler>)
endfunction()
