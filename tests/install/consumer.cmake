# SPDX-License-Identifier: Apache-2.0
#
# All that this build installs, used by programs of its own, as users would.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)

file(REMOVE_RECURSE ${WORK})
install_and_move(${BUILD})
consume(core io messages mcap server capture scenes evaluation)
consume_by_pkg_config(core io messages mcap server capture scenes evaluation)
run(${prefix}/bin/stereogrid --version)
