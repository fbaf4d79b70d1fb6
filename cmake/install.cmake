# SPDX-License-Identifier: Apache-2.0
#
# `cmake --install`: libraries, public headers, the tool, and the package that find_package(stereogrid CONFIG) reads.
# Every component has an export set of its own, so that the core can be used without the packages that io needs.
# COMPONENT is the Debian package that a file goes into (packaging/debian.cmake).

include(CMakePackageConfigHelpers)

set(stereogrid_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stereogrid)

# stereogrid_install_pc(NAME TARGET DESCRIPTION REQUIRES STATIC_REQUIRES STATIC_FLAGS): the file for pkg-config. It finds
# its folder by itself. A static library needs what it links to wherever it is linked, so that is Requires, not .private.
function(stereogrid_install_pc pc_name target description requires static_requires static_flags)
  set(link_flags)
  if(NOT BUILD_SHARED_LIBS)
    list(APPEND requires ${static_requires})
    set(library ${CMAKE_STATIC_LIBRARY_PREFIX}${target}${CMAKE_STATIC_LIBRARY_SUFFIX})
    set(link_flags "-Wl,--exclude-libs,${library} ${static_flags}")
  endif()
  list(JOIN requires ", " requires)
  file(RELATIVE_PATH prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  cmake_path(APPEND libdir "\${prefix}" ${CMAKE_INSTALL_LIBDIR})
  cmake_path(APPEND includedir "\${prefix}" ${CMAKE_INSTALL_INCLUDEDIR})
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${pc_name}.pc @ONLY CONTENT [[prefix=${pcfiledir}/@prefix_from_pc@
libdir=@libdir@
includedir=@includedir@

Name: @pc_name@
Description: @description@
Version: @PROJECT_VERSION@
Requires: @requires@
Libs: -L${libdir} -l@target@ @link_flags@
Cflags: -I${includedir}
]])
  install(FILES ${PROJECT_BINARY_DIR}/${pc_name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT development)
endfunction()

# stereogrid_install_component(NAME TARGET INCLUDE_FOLDER)
function(stereogrid_install_component name target headers)
  install(
    TARGETS ${target}
    EXPORT stereogrid_${name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libraries NAMELINK_COMPONENT development
    INCLUDES
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(DIRECTORY ${headers}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
          FILES_MATCHING PATTERN "*.hpp")
  install(
    EXPORT stereogrid_${name}
    NAMESPACE stereogrid::
    FILE stereogrid_${name}.cmake
    DESTINATION ${stereogrid_package_dir}
    COMPONENT development)
endfunction()

stereogrid_install_component(core stereogrid ${PROJECT_SOURCE_DIR}/include)
stereogrid_install_pc(stereogrid stereogrid "${PROJECT_DESCRIPTION}" "" "tbb;libhwy" "-ldl")
set(STEREOGRID_COMPONENTS core)
if(STEREOGRID_CUDA)
  install(TARGETS stereogrid_cuda LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT cuda)
endif()
if(STEREOGRID_IO)
  stereogrid_install_component(odometry stereogrid_odometry ${PROJECT_SOURCE_DIR}/odometry/include)
  stereogrid_install_pc(stereogrid-odometry stereogrid_odometry "Visual odometry for stereogrid" "stereogrid" "fmt"
                        "-lopencv_video -lopencv_calib3d -lopencv_imgproc -lopencv_core")
  stereogrid_install_component(io stereogrid_io ${PROJECT_SOURCE_DIR}/io/include)
  stereogrid_install_pc(stereogrid-io stereogrid_io "Images, calibration and recordings for stereogrid" "stereogrid;stereogrid-odometry"
                        "yaml-cpp;fmt;libzip;libisal;libturbojpeg;libtiff-4;libwebp;zlib" "-pthread")
  list(APPEND STEREOGRID_COMPONENTS odometry io)
endif()
if(STEREOGRID_CONNECTED)
  stereogrid_install_component(messages stereogrid_messages ${PROJECT_SOURCE_DIR}/messages/include)
  stereogrid_install_pc(stereogrid-messages stereogrid_messages "Results of stereogrid as ROS 2 messages" "stereogrid"
                        "" "")
  list(APPEND STEREOGRID_COMPONENTS messages)
  stereogrid_install_component(mcap stereogrid_mcap ${PROJECT_SOURCE_DIR}/mcap/include)
  stereogrid_install_pc(stereogrid-mcap stereogrid_mcap "MCAP files, and recordings of ROS 2" "stereogrid"
                        "stereogrid-io;libzstd;liblz4;sqlite3;yaml-cpp;fmt;zlib" "")
  list(APPEND STEREOGRID_COMPONENTS mcap)
  stereogrid_install_component(server stereogrid_server ${PROJECT_SOURCE_DIR}/server/include)
  stereogrid_install_pc(stereogrid-server stereogrid_server "Live results for viewers, by WebSocket and HTTP" "stereogrid" ""
                        "-pthread")
  list(APPEND STEREOGRID_COMPONENTS server)
  stereogrid_install_component(capture stereogrid_capture ${PROJECT_SOURCE_DIR}/capture/include)
  set(requires fmt)
  if(STEREOGRID_GSTREAMER)
    set(requires "gstreamer-app-1.0;gstreamer-video-1.0;fmt")
  endif()
  stereogrid_install_pc(stereogrid-capture stereogrid_capture "Live cameras for stereogrid" "stereogrid;stereogrid-io"
                        "${requires}" "-pthread")
  list(APPEND STEREOGRID_COMPONENTS capture)
endif()
if(STEREOGRID_TOOL)
  stereogrid_install_component(scenes stereogrid_scenes ${PROJECT_SOURCE_DIR}/scenes/include)
  stereogrid_install_pc(stereogrid-scenes stereogrid_scenes "Street scenes with ground truth" "stereogrid" "tbb" "")
  stereogrid_install_component(evaluation stereogrid_evaluation ${PROJECT_SOURCE_DIR}/evaluation/include)
  stereogrid_install_pc(stereogrid-evaluation stereogrid_evaluation "Scores of occupancy grids" "stereogrid" "" "")
  list(APPEND STEREOGRID_COMPONENTS scenes evaluation)
  if(BUILD_SHARED_LIBS)
    file(RELATIVE_PATH lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
    set_target_properties(stereogrid_tool PROPERTIES INSTALL_RPATH "$ORIGIN/${lib_from_bin}")
  endif()
  install(TARGETS stereogrid_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tool)
  set(completion ${PROJECT_SOURCE_DIR}/packaging/completion)
  install(FILES ${completion}/bash.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME stereogrid
          COMPONENT tool)
  set(zsh_functions zsh/site-functions)
  if(STEREOGRID_DEBIAN)
    set(zsh_functions zsh/vendor-completions) # packages' part of fpath
  endif()
  install(FILES ${completion}/zsh.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/${zsh_functions} RENAME _stereogrid
          COMPONENT tool)
  install(FILES ${completion}/fish.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d RENAME stereogrid.fish
          COMPONENT tool)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/packaging/fleet DESTINATION ${CMAKE_INSTALL_DATADIR}/stereogrid COMPONENT tool
          USE_SOURCE_PERMISSIONS PATTERN __pycache__ EXCLUDE)
  if(TARGET stereogrid_dds) # library that the tool loads
    install(TARGETS stereogrid_dds LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/stereogrid COMPONENT dds)
  endif()
endif()

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/stereogridConfig.cmake.in ${PROJECT_BINARY_DIR}/stereogridConfig.cmake
  INSTALL_DESTINATION ${stereogrid_package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/stereogridConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/stereogridConfig.cmake ${PROJECT_BINARY_DIR}/stereogridConfigVersion.cmake
        DESTINATION ${stereogrid_package_dir} COMPONENT development)
if(STEREOGRID_DEBIAN)
  include(packaging/debian.cmake)
else()
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
endif()
