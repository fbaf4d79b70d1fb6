#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Usage: wheel-dependencies.sh [PREFIX]. Builds the parts of OpenCV that a wheel contains as static libraries, from the
# source archive of PyPI's opencv-python-headless, and installs them below PREFIX (default /usr/local). In the containers
# of cibuildwheel (manylinux_2_34, AlmaLinux 9) it also installs the packages that a wheel is built with.
set -euo pipefail
prefix=${1:-/usr/local}
version=4.14.0.94

if command -v dnf >/dev/null; then
  dnf install -y epel-release
  dnf config-manager --set-enabled crb
  dnf install -y cmake ninja-build python3-pip yaml-cpp-devel json-devel fmt-devel tbb-devel highway-devel libzip-devel \
    isa-l-devel turbojpeg-devel libtiff-devel libwebp-devel zlib-devel libzstd-devel lz4-devel sqlite-devel cli11-devel \
    spdlog-devel boost-devel
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m pip download --quiet --no-deps --no-binary opencv-python-headless --dest "$folder" \
  "opencv-python-headless==$version"
tar -xzf "$folder"/opencv*.tar.gz -C "$folder"
cmake -G Ninja -S "$folder/opencv_python_headless-$version/opencv" -B "$folder/build" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_INSTALL_PREFIX="$prefix" -DBUILD_SHARED_LIBS=OFF -DENABLE_PIC=ON -DBUILD_LIST=core,imgproc,calib3d,video \
  -DCPU_DISPATCH=AVX2 -DWITH_LAPACK=OFF -DWITH_EIGEN=OFF -DWITH_IPP=OFF -DWITH_ITT=OFF -DWITH_OPENCL=OFF -DWITH_VA=OFF -DWITH_ADE=OFF \
  -DWITH_OPENJPEG=OFF -DWITH_PROTOBUF=OFF -DWITH_JASPER=OFF -DBUILD_TESTS=OFF -DBUILD_PERF_TESTS=OFF \
  -DBUILD_opencv_apps=OFF -DBUILD_JAVA=OFF
ninja -C "$folder/build" install
