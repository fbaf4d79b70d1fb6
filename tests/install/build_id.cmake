# SPDX-License-Identifier: Apache-2.0
#
# cmake -D SOURCE=… -D WORK=… -P build_id.cmake: the same sources have one build id wherever they are, others another.
cmake_minimum_required(VERSION 3.22)

function(get_build_id root result)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -D VERSION=1.2.3 -D ROOT=${root} -D OUTPUT=${WORK}/build_id.cpp -P
            ${SOURCE}/cmake/build_id.cmake COMMAND_ERROR_IS_FATAL ANY)
  file(READ ${WORK}/build_id.cpp text)
  if(NOT text MATCHES "\"(1\\.2\\.3\\+[0-9a-f]+)\"")
    message(FATAL_ERROR "no build id in ${text}")
  endif()
  set(${result} ${CMAKE_MATCH_1} PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
file(COPY ${SOURCE}/src ${SOURCE}/include DESTINATION ${WORK}/copy)
get_build_id(${SOURCE} original)
get_build_id(${WORK}/copy copy)
if(NOT original STREQUAL copy)
  message(FATAL_ERROR "a copy has another build id: ${original}, ${copy}")
endif()

file(APPEND ${WORK}/copy/src/config.cpp "\n")
get_build_id(${WORK}/copy changed)
file(RENAME ${WORK}/copy/src/pipeline/cuda/stages.hpp ${WORK}/copy/src/stages.hpp)
get_build_id(${WORK}/copy renamed)
if(changed STREQUAL copy OR renamed STREQUAL changed)
  message(FATAL_ERROR "the build id does not change with the sources: ${copy}, ${changed}, ${renamed}")
endif()
