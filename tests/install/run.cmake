# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# cmake -D BUILD=… -D SOURCE=… -D WORK=… -D GENERATOR=… -D CXX=… -D BUILD_TYPE=… -D SANITIZE=… -P run.cmake
cmake_minimum_required(VERSION 3.22)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
# what is installed has to work where it is moved to, and without the source tree
file(RENAME ${WORK}/installed ${WORK}/moved)
set(prefix ${WORK}/moved)

file(GLOB_RECURSE package_files ${prefix}/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "no CMake package was installed in ${prefix}")
endif()
foreach(package_file IN LISTS package_files)
  file(READ ${package_file} text)
  foreach(path IN ITEMS ${BUILD} ${SOURCE} ${WORK})
    string(FIND "${text}" "${path}" place)
    if(NOT place EQUAL -1)
      message(FATAL_ERROR "${package_file} names ${path}, which users do not have")
    endif()
  endforeach()
endforeach()

foreach(name IN ITEMS stereogrid-compare baselines research)
  file(GLOB_RECURSE found ${prefix}/*${name}*)
  if(found)
    message(FATAL_ERROR "research is not for users: ${found}")
  endif()
endforeach()

set(flags)
if(SANITIZE)
  set(flags "-DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE}")
endif()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${WORK}/consumer -G ${GENERATOR}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_BUILD_TYPE=${BUILD_TYPE} ${flags})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
foreach(program IN ITEMS uses_core uses_io uses_scenes uses_evaluation)
  run(${CMAKE_COMMAND} -E chdir ${WORK}/consumer ./${program})
endforeach()
run(${prefix}/bin/stereogrid --version)
