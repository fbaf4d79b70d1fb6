#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Installs what a wheel is built with in the containers of cibuildwheel (manylinux_2_34, AlmaLinux 9).
set -euo pipefail

dnf install -y epel-release
dnf config-manager --set-enabled crb
dnf install -y opencv-devel yaml-cpp-devel json-devel fmt-devel tbb-devel highway-devel libzip-devel libdeflate-devel \
  zlib-devel libzstd-devel lz4-devel sqlite-devel
