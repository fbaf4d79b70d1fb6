# SPDX-License-Identifier: Apache-2.0
#
# The core as a subproject.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)

function(install_only build programs)
  run(${CMAKE_COMMAND} --install ${build} --prefix ${build}/installed)
  file(GLOB_RECURSE files RELATIVE ${build}/installed ${build}/installed/*)
  if(NOT files STREQUAL programs)
    message(FATAL_ERROR "the parent's install should have ${programs} alone: ${files}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK} ${AGAIN})
set(parent ${CMAKE_CURRENT_LIST_DIR}/subproject)

# a parent that sets nothing, and uses no target: nothing is set for it, nothing built
run(${CMAKE_COMMAND} -S ${parent} -B ${WORK}/bystander ${GENERATOR} -D CMAKE_CXX_COMPILER=${CXX}
    -D STEREOGRID_SOURCE=${SOURCE} -D USED=OFF)
run(${CMAKE_COMMAND} --build ${WORK}/bystander)
file(GLOB_RECURSE built ${WORK}/bystander/*.o ${WORK}/bystander/*.a)
list(FILTER built EXCLUDE REGEX "/CMakeFiles/[0-9.]+/|/parent.dir/")
if(built)
  message(FATAL_ERROR "EXCLUDE_FROM_ALL, yet built: ${built}")
endif()
install_only(${WORK}/bystander bin/parent)

# not built: what the linker gets is known before
run(${CMAKE_COMMAND} -S ${parent} -B ${WORK}/sanitized ${GENERATE} -D CMAKE_CXX_COMPILER=${CXX}
    -D STEREOGRID_SOURCE=${SOURCE} -D USED=ON -D STEREOGRID_SANITIZE=address)

run(${CMAKE_COMMAND} -S ${parent} -B ${AGAIN} ${GENERATE} ${COMPILE} -D STEREOGRID_SOURCE=${SOURCE} -D USED=ON
    -D SETTINGS=${SETTINGS})
run(${CMAKE_COMMAND} --build ${AGAIN})
run(${AGAIN}/parent)
install_only(${AGAIN} bin/parent)
