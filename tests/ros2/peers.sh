#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# peers.sh SOURCE TOOL DISTRO TEST: a test of tests/ros2/peers with the Python and the packages of build/ros/DISTRO.
# Fast DDS may loop without end when rclpy takes a sample from it. Then, and only then, the test is repeated, once.
set -euo pipefail

source=$1
ros=$source/build/ros/$3
[ -e "$ros/installed.txt" ] || { echo "SKIPPED: no ROS 2 in $ros (scripts/install-dependencies.sh --python)"; exit 77; }
export STEREOGRID_TOOL=$2 AMENT_PREFIX_PATH=$ros LD_LIBRARY_PATH=$ros/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
log=$(mktemp)
trap 'rm -f "$log"' EXIT
run() { "$ros/bin/python" -W ignore "$source/tests/ros2/peers/$4_test.py" 2>&1 | tee "$log"; }
run "$@" && exit
grep -A2 'Timeout (' "$log" | grep -q 'rclpy/executors.py.* in _take_subscription' || exit 1
echo "REPEATED: Fast DDS did not return from take"
run "$@"
