#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs the Debian / Ubuntu packages that stereogrid is built, tested and run with.
# Does nothing where they are all there. Uses sudo where the caller is not root.
# --tool: only those that the tool is built and run with, without the tests' and ffmpeg, which reads and writes videos.
# --python: also the packages of PyPI that the Python package is built and tested with, into build/python/venv, and ROS 2
# as peers of tests, into build/ros/jazzy and build/ros/kilted. Where one of them cannot be installed, its tests are
# skipped.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

packages=(
  g++ cmake ninja-build ccache pkg-config git        # build
  libopencv-dev libyaml-cpp-dev nlohmann-json3-dev   # calibration and odometry, YAML in, JSON out
  libturbojpeg0-dev libtiff-dev libwebp-dev          # images
  libcli11-dev libspdlog-dev libfmt-dev              # command line, log
  libtbb-dev libhwy-dev                              # threads, SIMD
  libzip-dev libisal-dev zlib1g-dev                  # .npz, PNG
  libzstd-dev liblz4-dev libsqlite3-dev              # recordings: MCAP, rosbag2
  libssl-dev                                         # hashes of types of ROS 2
  libboost-dev                                       # server: WebSocket and HTTP (headers)
  libgstreamer-plugins-base1.0-dev                   # live cameras
  gstreamer1.0-plugins-base gstreamer1.0-plugins-good
  cyclonedds-dev                                     # ROS 2
)
if [ "${1:-}" != "--tool" ]; then
  packages+=(
    libgtest-dev libgmock-dev libbenchmark-dev # tests, benchmarks
    libboost-context-dev                       # tests of CUDA kernels without a GPU
    ffmpeg                                     # videos, and --video
    fish zsh                                   # completion of the command line
    python3 python3-numpy                      # tests that read our files as users do
    python3-matplotlib                         # research/compare.py --figure
  )
fi
if [ "${1:-}" = "--ci" ]; then
  packages+=(
    clang-format clang-tidy
    clang libclang-rt-dev  # fuzzers
    nodejs                 # the report's script
    chromium               # the viewer's page
    abigail-tools          # the shared core's interface
    cyclonedds-tools       # peers of ROS 2 in tests
    ament-cmake ament-cmake-copyright ament-cmake-cpplint ament-cmake-flake8 ament-cmake-lint-cmake ament-cmake-pep257 ament-cmake-xmllint  # ros2/
    snakemake              # fleets of drives
    python3-pip            # scripts/install-cuda.sh
    gstreamer1.0-plugins-bad gstreamer1.0-tools  # images from another program: shmsink
    valgrind               # instructions of a frame
    colcon python3-colcon-cmake python3-colcon-ros python3-colcon-recursive-crawl python3-colcon-package-information
  )
  # foreign peers of tests; other packages of Node.js bring it themselves and exclude Debian's
  command -v npm >/dev/null || packages+=(npm)
fi
[ "${1:-}" != "--package" ] || packages+=(help2man dpkg-dev) # scripts/package.sh
[ "${1:-}" != "--python" ] || packages+=(python3-dev python3-venv)

install_python_packages() { # install_python_packages VENV REQUIREMENTS
  local venv=$root/$1 requirements=$root/$2
  ! cmp -s "$requirements" "$venv/installed.txt" || return 0
  echo "Installing Python packages for tests: $requirements"
  # Debian's Python, which has Debian's headers
  if /usr/bin/python3 -m venv "$venv" &&
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$requirements"; then
    cp "$requirements" "$venv/installed.txt"
  else
    echo "Tests are skipped: pip could not install $requirements." >&2
  fi
}

finish() {
  if [ "$1" = "--python" ]; then
    install_python_packages build/python/venv tests/python/requirements.txt &
    ROS_DISTRO=jazzy install_python_packages build/ros/jazzy tests/ros2/requirements.txt &
    ROS_DISTRO=kilted install_python_packages build/ros/kilted tests/ros2/requirements.txt &
    wait
  fi
  exit 0
}

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || finish "${1:-}"

if ! command -v apt-get >/dev/null; then
  echo "These packages are missing and apt-get is not here to install them: ${missing[*]}" >&2
  exit 1
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "Run as root, or install sudo: packages are missing: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "Installing: ${missing[*]}"
"${as_root[@]}" apt-get update -qq
# waits while another apt, such as a new machine's automatic upgrade, holds the lock
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 install -y -qq \
  --no-install-recommends "${missing[@]}" >/dev/null
finish "${1:-}"
