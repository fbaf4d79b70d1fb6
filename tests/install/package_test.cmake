# SPDX-License-Identifier: Apache-2.0
#
# The package as users meet it: cmake -D CASE=… -D SETTINGS=… -D WORK=… -D AGAIN=… -D CUDA_LIBRARY=… -P package_test.cmake. It works in
# WORK, and builds the core again in AGAIN.
cmake_minimum_required(VERSION 3.22)
include(${SETTINGS})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

# install_and_move(BUILD): sets `prefix`. Installed files have to work after a move, without the source tree.
macro(install_and_move build)
  run(${CMAKE_COMMAND} --install ${build} --prefix ${WORK}/installed)
  file(RENAME ${WORK}/installed ${WORK}/moved)
  set(prefix ${WORK}/moved)
  file(GLOB_RECURSE package_files ${prefix}/*.cmake ${prefix}/*.pc)
  if(NOT package_files MATCHES "stereogridConfig.cmake" OR NOT package_files MATCHES "stereogrid.pc")
    message(FATAL_ERROR "no package for CMake and pkg-config was installed in ${prefix}: ${package_files}")
  endif()
  foreach(package_file IN LISTS package_files)
    file(READ ${package_file} text)
    foreach(path IN ITEMS ${build} ${SOURCE} ${WORK})
      string(FIND "${text}" "${path}" place)
      if(NOT place EQUAL -1)
        message(FATAL_ERROR "${package_file} names ${path}, which users do not have")
      endif()
    endforeach()
  endforeach()
  foreach(name IN ITEMS baselines research)
    file(GLOB_RECURSE found ${prefix}/*${name}*)
    if(found)
      message(FATAL_ERROR "research is not for users: ${found}")
    endif()
  endforeach()
endmacro()

# consume(COMPONENT…): with `options` builds and runs the programs of consumer/ that use these components, and the plugin, with each
# compiler.
function(consume)
  list(JOIN ARGN "," components)
  foreach(compiler IN ITEMS ${CXX} ${OTHER_CXX})
    get_filename_component(name ${compiler} NAME)
    set(build ${WORK}/consumer-${name})
    run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${build} ${GENERATE} -D COMPONENTS=${components}
        -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${compiler} -D SANITIZE=${SANITIZE} ${options})
    run(${CMAKE_COMMAND} --build ${build})
    foreach(component IN LISTS ARGN)
      run(${CMAKE_COMMAND} -E chdir ${build} ./uses_${component})
    endforeach()
    if(CUDA_LIBRARY)
      run(${CMAKE_COMMAND} -E env STEREOGRID_CUDA_LIBRARY=${CUDA_LIBRARY} STEREOGRID_EMULATOR_LACKS=device
          ${build}/uses_core cuda)
    endif()
    run(${build}/uses_plugin ${build}/libplugin.so)
    run(${PYTHON} ${CMAKE_CURRENT_LIST_DIR}/symbols.py plugin ${NM} ${build}/libplugin.so)
  endforeach()
endfunction()

# consume_by_pkg_config(COMPONENT…): the same without CMake.
function(consume_by_pkg_config)
  file(GLOB_RECURSE file ${prefix}/*/stereogrid.pc)
  get_filename_component(folder ${file} DIRECTORY)
  set(ENV{PKG_CONFIG_PATH} ${folder})
  set(ENV{LD_LIBRARY_PATH} ${folder}/..)
  set(sources ${CMAKE_CURRENT_LIST_DIR}/consumer)
  foreach(component IN LISTS ARGN)
    string(REPLACE "-core" "" package stereogrid-${component})
    execute_process(COMMAND pkg-config --cflags --libs ${package} OUTPUT_VARIABLE flags
                    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags)
    if(SANITIZE)
      list(APPEND flags -fsanitize=${SANITIZE})
    endif()
    set(program ${WORK}/${package})
    set(source ${sources}/core.cpp)
    if(NOT component STREQUAL "core")
      string(TOUPPER ${component} name)
      set(source -DUSES_${name} ${sources}/components.cpp)
    endif()
    run(${CXX} -std=c++20 -Wall -Wextra -Wpedantic -Werror ${source} -o ${program} ${flags})
    run(${CMAKE_COMMAND} -E chdir ${WORK} ${program})
    if(component STREQUAL "core")
      set(plugin ${WORK}/plugin_by_pkg_config.so)
      run(${CXX} -std=c++20 -shared -fPIC -fvisibility=hidden ${sources}/plugin.cpp -o ${plugin} ${flags})
      run(${PYTHON} ${CMAKE_CURRENT_LIST_DIR}/symbols.py plugin ${NM} ${plugin})
    endif()
  endforeach()
endfunction()

function(install_only build programs)
  run(${CMAKE_COMMAND} --install ${build} --prefix ${build}/installed)
  file(GLOB_RECURSE files RELATIVE ${build}/installed ${build}/installed/*)
  if(NOT files STREQUAL programs)
    message(FATAL_ERROR "the parent's install should have ${programs} alone: ${files}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK} ${AGAIN})
if(CASE STREQUAL "consumer") # All that this build installs, used by programs of its own, as users would.
  install_and_move(${BUILD})
  consume(core io messages mcap server capture scenes evaluation)
  consume_by_pkg_config(core io messages mcap server capture scenes evaluation)
  run(${prefix}/bin/stereogrid --version)
elseif(CASE STREQUAL "shared") # Core, io and messages, without the tool, as shared libraries: who links them, and what the core shows.
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
elseif(CASE STREQUAL "subproject") # The core as a subproject.
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
endif()
