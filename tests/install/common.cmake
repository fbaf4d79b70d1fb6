# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# What the scripts share. Each is called with -D SETTINGS=… -D WORK=… -D AGAIN=…
# -D CUDA_LIBRARY=… -P SCRIPT; it works in WORK, and builds the core again in AGAIN.
include(${SETTINGS})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

# install_and_move(BUILD): sets `prefix`. What is installed has to work where it is moved to, without the source tree.
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
          ${build}/uses_cuda_library)
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
    run(${CXX} -std=c++20 -Wall -Wextra -Wpedantic -Werror ${sources}/uses_${component}.cpp -o ${program} ${flags})
    run(${CMAKE_COMMAND} -E chdir ${WORK} ${program})
    if(component STREQUAL "core")
      set(plugin ${WORK}/plugin_by_pkg_config.so)
      run(${CXX} -std=c++20 -shared -fPIC -fvisibility=hidden ${sources}/plugin.cpp -o ${plugin} ${flags})
      run(${PYTHON} ${CMAKE_CURRENT_LIST_DIR}/symbols.py plugin ${NM} ${plugin})
    endif()
  endforeach()
endfunction()
