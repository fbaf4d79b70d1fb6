# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Copyright 2026 The stereogrid authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.
"""stereogrid as a component in a container of its own."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    """Arguments: camera (namespace of left/), parameters (YAML file), autostart, rviz."""
    share = FindPackageShare('stereogrid_ros')
    usual = PathJoinSubstitution([share, 'config', 'stereo_grid.yaml'])
    camera = LaunchConfiguration('camera')
    images = [f'{image}/image_{kind}{transport}'
              for image in ('left', 'right', 'depth') for kind in ('rect', 'raw')
              for transport in ('', '/compressed', '/compressedDepth')]
    topics = images + ['left/camera_info', 'right/camera_info', 'disparity']
    autostart = ParameterValue(LaunchConfiguration('autostart'), value_type=bool)
    node = ComposableNode(
        package='stereogrid_ros',
        plugin='stereogrid_ros::StereoGridNode',
        name='stereo_grid',
        parameters=[LaunchConfiguration('parameters'), {'autostart': autostart}],
        remappings=[(topic, [camera, '/' + topic]) for topic in topics])
    return LaunchDescription([
        DeclareLaunchArgument('camera', default_value='/stereo'),
        DeclareLaunchArgument('parameters', default_value=usual),
        DeclareLaunchArgument('autostart', default_value='true'),
        DeclareLaunchArgument('rviz', default_value='false'),
        Node(
            package='rviz2',
            executable='rviz2',
            arguments=['-d', PathJoinSubstitution([share, 'config', 'stereo_grid.rviz'])],
            condition=IfCondition(LaunchConfiguration('rviz'))),
        ComposableNodeContainer(
            name='stereo_grid_container',
            namespace='',
            package='rclcpp_components',
            executable='component_container_mt',
            composable_node_descriptions=[node],
            output='screen'),
    ])
