#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# colcon.sh SOURCE BUILD WORK: the packages in ros2/ as a workspace of colcon has them: ament_cmake is Debian's, stereogrid
# is BUILD, installed; rclcpp, rclcpp_components, rclcpp_lifecycle, tf2_ros, pluginlib and nav2_costmap_2d are the stand-ins of this folder, which export
# targets as the real ones do. Messages are the real packages where scripts/install-dependencies.sh --python has put them. Where Debian has
# the linters of ament, they check the packages.
set -euo pipefail

source=$1
build=$2
work=$3
skip=77
packages="stereogrid_nav2 stereogrid_ros"
stand_in=$source/tests/ros2/stand_in
command -v colcon >/dev/null || { echo "SKIPPED: there is no colcon"; exit $skip; }
[ -d /usr/share/ament_cmake ] || { echo "SKIPPED: there is no ament_cmake"; exit $skip; }
fail() { echo "FAILED: $*" >&2; exit 1; }

rm -rf "$work"
mkdir -p "$work/workspace/src"
for package in $packages; do ln -s "$source/ros2/$package" "$work/workspace/src/"; done
export_stand_in() { # export_stand_in PACKAGE TARGET FOLDER
  mkdir -p "$work/stand_in/share/$1/cmake"
  cat >"$work/stand_in/share/$1/cmake/$1Config.cmake" <<CONFIG
if(TARGET $1::$2)
  return()
endif()
add_library($1::$2 INTERFACE IMPORTED)
target_include_directories($1::$2 INTERFACE "$3")
set($1_TARGETS $1::$2)
CONFIG
}
export_stand_in rclcpp rclcpp "$stand_in"
export_stand_in rclcpp_components component "$stand_in"
export_stand_in rclcpp_lifecycle rclcpp_lifecycle "$stand_in"
export_stand_in tf2_ros tf2_ros "$stand_in"
export_stand_in pluginlib pluginlib "$stand_in"
export_stand_in nav2_costmap_2d nav2_costmap_2d_core "$stand_in"
ros=$source/build/ros/jazzy
if [ -e "$ros/share/sensor_msgs/cmake/sensor_msgsConfig.cmake" ]; then
  echo "Messages: the packages of $ros"
  # these wheels name the folder of Python's headers on the machine that has built them
  { grep -rlE '/opt/python/[^";]*' "$ros"/share/*/cmake || true; } | xargs -r sed -i -E 's#/opt/python/[^";]*#/usr/include#g'
else
  echo "Messages: stand-ins; scripts/install-dependencies.sh --python installs the real packages"
  ros=
  for name in geometry_msgs nav_msgs sensor_msgs stereo_msgs; do
    export_stand_in $name ${name}__rosidl_typesupport_cpp "$build/tests/ros2/stand_in_messages"
  done
fi
cat >>"$work/stand_in/share/rclcpp_components/cmake/rclcpp_componentsConfig.cmake" <<'MACRO'
macro(rclcpp_components_register_nodes target)
  if(NOT TARGET ${target} OR NOT "${ARGN}" STREQUAL "stereogrid_ros::StereoGridNode")
    message(FATAL_ERROR "not as rclcpp_components has it")
  endif()
endmacro()
MACRO
cat >>"$work/stand_in/share/pluginlib/cmake/pluginlibConfig.cmake" <<'MACRO'
macro(pluginlib_export_plugin_description_file base file) # as pluginlib's
  install(FILES ${file} DESTINATION share/${PROJECT_NAME})
  ament_index_register_resource(${base}__pluginlib__plugin CONTENT "share/${PROJECT_NAME}/${file}\n")
endmacro()
MACRO
cmake --install "$build" --prefix "$work/installed" >"$work/install.log" || fail "installing stereogrid"

version=$(sed -n 's/^project(stereogrid VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")
cd "$work/workspace"
for package in $packages; do
  grep -q "<version>$version</version>" "src/$package/package.xml" || fail "package.xml of $package is not of version $version"
  colcon list | grep -q "$package.*(ros.ament_cmake)" || fail "colcon does not see the ament_cmake package $package"
done
testing=OFF
[ ! -d /usr/share/ament_cmake_copyright ] || testing=ON
settings=(-GNinja -DPython3_EXECUTABLE=/usr/bin/python3 -DBUILD_SHARED_LIBS=ON -DBUILD_TESTING=$testing)
build_packages() { # build_packages PREFIXES [OPTION…]
  env ${ros:+AMENT_PREFIX_PATH="$ros"} colcon build --event-handlers console_direct+ "${@:2}" \
    --cmake-args "${settings[@]}" -DCMAKE_PREFIX_PATH="$1$work/stand_in${ros:+;$ros}" >"$work/colcon.log" 2>&1 ||
    { tail -30 "$work/colcon.log"; fail "colcon build"; }
}
build_packages "$work/installed;"
index=share/ament_index/resource_index
for file in stereogrid_ros/lib/libstereogrid_ros.so stereogrid_ros/lib/stereogrid_ros/stereo_grid \
  stereogrid_ros/share/stereogrid_ros/{launch/stereo_grid.launch.py,config/stereo_grid.yaml,config/stereo_grid.rviz} stereogrid_ros/$index/packages/stereogrid_ros \
  stereogrid_nav2/lib/libstereogrid_nav2.so stereogrid_nav2/share/stereogrid_nav2/layers.xml \
  stereogrid_nav2/$index/nav2_costmap_2d__pluginlib__plugin/stereogrid_nav2; do
  [ -e "install/$file" ] || fail "not installed: $file"
done

# One clone: the library's project has both packages. Only the layer is compiled, since the library was before.
for dependency in $(sed -n 's/^ *<[a-z_]*depend>\(.*\)<.*/\1/p' "$source/ros2/stereogrid_ros/package.xml"); do
  grep -q "depend>$dependency<" "$source/package.xml" || fail "package.xml lacks $dependency, which stereogrid_ros has"
done
grep -q "<version>$version</version>" "$source/package.xml" || fail "package.xml is not of version $version"
[ "$(colcon list --base-paths "$source" | sed 's/\t.*\t/ /')" = "stereogrid (ros.cmake)" ] || fail "colcon does not see one package"
grep -q "^cmake-args:.*-DSTEREOGRID_ROS2=ON" "$source/colcon.pkg" || fail "colcon.pkg does not set STEREOGRID_ROS2"
settings+=(-DSTEREOGRID_ROS2=ON -DSTEREOGRID_TESTS=OFF -DSTEREOGRID_TOOL=OFF -DSTEREOGRID_IO=ON -DSTEREOGRID_CONNECTED=ON)
build_packages "" --base-paths "$source" --build-base clone --cmake-target stereogrid_nav2
for file in packages/stereogrid_ros nav2_costmap_2d__pluginlib__plugin/stereogrid_nav2; do
  [ -e "clone/stereogrid/ament_cmake_index/share/ament_index/resource_index/$file" ] || fail "not in the index: $file"
done
for target in stereo_grid libstereogrid_ros.so; do
  ninja -C clone/stereogrid -t query "$target" >/dev/null || fail "no target $target in the library's project"
done

if [ $testing = ON ]; then
  colcon test >"$work/test.log" 2>&1 && colcon test-result || fail "ament's linters: colcon test"
elif command -v ament_lint_cmake >/dev/null; then
  ament_lint_cmake src/*/ && ament_flake8 src/*/launch && ament_pep257 src/*/launch || fail "ament's linters"
else
  echo "ament's linters are not here: not looked through"
fi
