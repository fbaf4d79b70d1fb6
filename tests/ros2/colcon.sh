#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# colcon.sh SOURCE BUILD WORK: ros2/stereogrid_ros as a workspace of colcon has it: ament_cmake is Debian's, stereogrid
# is BUILD, installed; rclcpp and its company are the stand-ins of this folder. Where Debian has the linters of ament,
# they look through the package.
set -euo pipefail

source=$1
build=$2
work=$3
skip=77
package=$source/ros2/stereogrid_ros
stand_in=$source/tests/ros2/stand_in
command -v colcon >/dev/null || { echo "SKIPPED: there is no colcon"; exit $skip; }
[ -d /usr/share/ament_cmake ] || { echo "SKIPPED: there is no ament_cmake"; exit $skip; }
fail() { echo "FAILED: $*" >&2; exit 1; }

rm -rf "$work"
mkdir -p "$work/workspace/src"
ln -s "$package" "$work/workspace/src/"
for name in geometry_msgs rclcpp rclcpp_components sensor_msgs tf2_ros; do
  mkdir -p "$work/stand_in/share/$name/cmake"
  echo "set(${name}_INCLUDE_DIRS \"$stand_in\")" >"$work/stand_in/share/$name/cmake/${name}Config.cmake"
done
cat >>"$work/stand_in/share/rclcpp_components/cmake/rclcpp_componentsConfig.cmake" <<'MACRO'
macro(rclcpp_components_register_node target)
  cmake_parse_arguments(NODE "" "PLUGIN;EXECUTABLE" "" ${ARGN})
  if(NOT TARGET ${target} OR NOT NODE_PLUGIN STREQUAL "stereogrid_ros::StereoGridNode" OR NODE_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "not as rclcpp_components has it")
  endif()
endmacro()
MACRO
cmake --install "$build" --prefix "$work/installed" >"$work/install.log" || fail "installing stereogrid"

version=$(sed -n 's/^project(stereogrid VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")
grep -q "<version>$version</version>" "$package/package.xml" || fail "package.xml is not of version $version"
cd "$work/workspace"
colcon list | grep -q "stereogrid_ros.*(ros.ament_cmake)" || fail "colcon does not see an ament_cmake package"
colcon build --event-handlers console_direct+ --cmake-args -GNinja -DPython3_EXECUTABLE=/usr/bin/python3 -DBUILD_SHARED_LIBS=ON \
  -DCMAKE_PREFIX_PATH="$work/installed;$work/stand_in" >"$work/colcon.log" 2>&1 || { tail -30 "$work/colcon.log"; fail "colcon build"; }
for file in lib/libstereogrid_ros.so share/stereogrid_ros/launch/stereo_grid.launch.py \
  share/stereogrid_ros/config/stereo_grid.yaml share/ament_index/resource_index/packages/stereogrid_ros; do
  [ -e "install/stereogrid_ros/$file" ] || fail "not installed: $file"
done

if command -v ament_lint_cmake >/dev/null; then
  ament_lint_cmake "$package" && ament_flake8 "$package/launch" && ament_pep257 "$package/launch" || fail "ament's linters"
else
  echo "ament's linters are not here: not looked through"
fi
