# SPDX-License-Identifier: Apache-2.0
#
# Core, io and messages, without the tool, as shared libraries: who links them, and what the core shows.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)

file(REMOVE_RECURSE ${WORK} ${AGAIN})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${AGAIN} ${GENERATE} ${COMPILE} -D BUILD_SHARED_LIBS=ON
    -D STEREOGRID_TOOL=OFF -D STEREOGRID_IO=ON -D STEREOGRID_CONNECTED=ON -D STEREOGRID_TESTS=OFF)
run(${CMAKE_COMMAND} --build ${AGAIN})
install_and_move(${AGAIN})

file(GLOB_RECURSE library ${prefix}/*/libstereogrid.so)
if(NOT library)
  message(FATAL_ERROR "BUILD_SHARED_LIBS=ON installed no libstereogrid.so")
endif()
run(${PYTHON} ${CMAKE_CURRENT_LIST_DIR}/symbols.py library ${NM} ${library} ${prefix}/include)

# programs look for the name with the minor version: before 1.0 another one may break them
file(STRINGS ${SOURCE}/CMakeLists.txt version REGEX "^project\\(stereogrid VERSION")
string(REGEX REPLACE ".*VERSION ([0-9]+\\.[0-9]+)\\..*" "\\1" minor "${version}")
execute_process(COMMAND readelf -d ${library} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
if(NOT text MATCHES "SONAME[^\n]*\\[libstereogrid.so.${minor}\\]" OR NOT EXISTS ${library}.${minor})
  message(FATAL_ERROR "the shared library's name is not libstereogrid.so.${minor}:\n${text}")
endif()

# nothing but the libraries is needed
set(options -D CMAKE_DISABLE_FIND_PACKAGE_TBB=ON -D CMAKE_DISABLE_FIND_PACKAGE_OpenCV=ON
            -D CMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON)
consume(core io messages)
consume_by_pkg_config(core io messages)
