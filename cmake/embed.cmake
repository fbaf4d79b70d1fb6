# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0

# stereogrid_embed(FOLDER FUNCTION TEMPLATE OUTPUT): the page in a folder, as C++. @STEREOGRID_EMBEDDED@ in the template
# becomes a list of {path, content type, bytes} of its .html, .css and .js files, @STEREOGRID_FUNCTION@ the function that
# returns it; index.html has the path "/".
function(stereogrid_embed folder STEREOGRID_FUNCTION template output)
  set(html "text/html")
  set(css "text/css")
  set(js "text/javascript")
  set(STEREOGRID_EMBEDDED "")
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*.html ${folder}/*.css ${folder}/*.js)
  foreach(file IN LISTS files)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
    string(REGEX MATCH "[a-z]+$" type ${file})
    string(REGEX REPLACE "^index.html$" "" path ${file})
    file(READ ${folder}/${file} text)
    string(APPEND STEREOGRID_EMBEDDED
           "    {\"/${path}\", \"${${type}}; charset=utf-8\", R\"~embedded~(${text})~embedded~\"},\n")
  endforeach()
  configure_file(${template} ${output} @ONLY)
endfunction()
