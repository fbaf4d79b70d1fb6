# SPDX-License-Identifier: Apache-2.0

# stereogrid_embed(FOLDER FUNCTION OUTPUT): the files of a folder as C++. The function, declared in connect/page.hpp,
# returns a list of {path, content type, bytes}; index.html has the path "/".
function(stereogrid_embed folder function output)
  set(html "text/html")
  set(css "text/css")
  set(js "text/javascript")
  set(sh "text/x-shellscript")
  set(STEREOGRID_EMBEDDED "")
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*.html ${folder}/*.css ${folder}/*.js
       ${folder}/*.sh)
  if(NOT files)
    message(FATAL_ERROR "${folder} has no files to embed")
  endif()
  foreach(file IN LISTS files)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
    string(REGEX MATCH "[a-z]+$" type ${file})
    string(REGEX REPLACE "^index.html$" "" path ${file})
    file(READ ${folder}/${file} text)
    string(APPEND STEREOGRID_EMBEDDED
           "    {\"/${path}\", \"${${type}}; charset=utf-8\", R\"~embedded~(${text})~embedded~\"},\n")
  endforeach()
  file(CONFIGURE OUTPUT ${output} CONTENT [[#include "connect/page.hpp"
std::vector<stereogrid::server::Asset> stereogrid::app::@function@() {
  return {
@STEREOGRID_EMBEDDED@
  };
}
]] @ONLY)
endfunction()
