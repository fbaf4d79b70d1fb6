# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
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
