# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# `cmake --install`: libraries, public headers, the tool, and the package that find_package(stereogrid CONFIG) reads.
# Every component has an export set of its own, so that the core can be used without the packages that io needs.

include(CMakePackageConfigHelpers)

set(stereogrid_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stereogrid)

# stereogrid_install_component(NAME TARGET INCLUDE_FOLDER)
function(stereogrid_install_component name target headers)
  install(
    TARGETS ${target}
    EXPORT stereogrid_${name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    INCLUDES
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(DIRECTORY ${headers}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
  install(
    EXPORT stereogrid_${name}
    NAMESPACE stereogrid::
    FILE stereogrid_${name}.cmake
    DESTINATION ${stereogrid_package_dir})
endfunction()

stereogrid_install_component(core stereogrid ${PROJECT_SOURCE_DIR}/include)
set(STEREOGRID_COMPONENTS core)
if(STEREOGRID_CUDA)
  install(TARGETS stereogrid_cuda LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
if(STEREOGRID_TOOL)
  stereogrid_install_component(io stereogrid_io ${PROJECT_SOURCE_DIR}/io/include)
  stereogrid_install_component(scenes stereogrid_scenes ${PROJECT_SOURCE_DIR}/scenes/include)
  stereogrid_install_component(evaluation stereogrid_evaluation ${PROJECT_SOURCE_DIR}/evaluation/include)
  list(APPEND STEREOGRID_COMPONENTS io scenes evaluation)
  install(TARGETS stereogrid_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/stereogridConfig.cmake.in ${PROJECT_BINARY_DIR}/stereogridConfig.cmake
  INSTALL_DESTINATION ${stereogrid_package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/stereogridConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/stereogridConfig.cmake ${PROJECT_BINARY_DIR}/stereogridConfigVersion.cmake
        DESTINATION ${stereogrid_package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
