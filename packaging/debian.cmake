# SPDX-License-Identifier: Apache-2.0
#
# Debian packages by CPack, as scripts/package.sh makes them: shared libraries below /usr.

# a library's package is named after what programs look for; before 1.0 that has the minor version
set(runtime libstereogrid${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(same_version "(= ${PROJECT_VERSION})")

# stereogrid_debian(COMPONENT PACKAGE SECTION DEPENDS TEXT): the documents that every package has, and its control fields.
# DEPENDS is beside the libraries that its programs link.
macro(stereogrid_debian component package section depends text)
  set(documents ${PROJECT_BINARY_DIR}/debian)
  file(WRITE ${documents}/changelog "stereogrid (${PROJECT_VERSION}) unstable; urgency=medium

  * CHANGELOG.md of the sources lists the changes.

 -- The stereogrid authors <stereogrid@example.org>  ${STEREOGRID_DATE}
")
  execute_process(COMMAND gzip -9nf ${documents}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${documents}/changelog.gz ${PROJECT_SOURCE_DIR}/packaging/copyright
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
  string(TOUPPER ${component} field)
  set(CPACK_DEBIAN_${field}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${field}_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_${field}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${field}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_DEBIAN_${field}_DESCRIPTION "${what}\n${text}")
  list(APPEND CPACK_COMPONENTS_ALL ${component})
endmacro()

set(what "From a stereo camera's images: which ground is occupied, and how what\nstands there moves.")
stereogrid_debian(libraries ${runtime} libs "" "These are the libraries that programs link.")
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
# CPack also calls ldconfig in scripts, which cannot be disabled
file(WRITE ${PROJECT_BINARY_DIR}/debian/${runtime} "${runtime}: maintscript-calls-ldconfig\n")
install(FILES ${PROJECT_BINARY_DIR}/debian/${runtime} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides
        COMPONENT libraries)
stereogrid_debian(development libstereogrid-dev libdevel "${runtime} ${same_version}"
                  "Headers, and files for CMake and pkg-config.")
stereogrid_debian(tool stereogrid science "${runtime} ${same_version}"
                  "The command-line tool, with a page for the browser.")
set(CPACK_DEBIAN_TOOL_PACKAGE_SUGGESTS "ffmpeg, snakemake, stereogrid-dds, stereogrid-doc")
stereogrid_debian(documentation stereogrid-doc doc ""
                  "Pages on every command, the method and its results, in Markdown.")
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_ARCHITECTURE all)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/stereogrid-doc
        COMPONENT documentation)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/ARCHITECTURE.md
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/stereogrid-doc COMPONENT documentation)
if(TARGET stereogrid_dds)
  stereogrid_debian(dds stereogrid-dds science "stereogrid ${same_version}"
                    "What the tool loads to be a node of ROS 2, without ROS installed.")
endif()
if(STEREOGRID_CUDA)
  stereogrid_debian(cuda stereogrid-cuda science "${runtime} ${same_version}" "The pipeline for GPUs of NVIDIA.")
endif()

file(GLOB manuals ${PROJECT_BINARY_DIR}/man/*.1.gz)
install(FILES ${manuals} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tool)
install(FILES ${PROJECT_SOURCE_DIR}/packaging/stereogrid-live@.service DESTINATION lib/systemd/system COMPONENT tool)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME stereogrid)
set(CPACK_PACKAGE_CONTACT "The stereogrid authors <stereogrid@example.org>")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/bin)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
