# SPDX-License-Identifier: Apache-2.0
#
# Libraries beside the core.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)

find_package(OpenCV REQUIRED COMPONENTS core imgproc calib3d video)
stereogrid_library(odometry src/odometry.cpp)
target_include_directories(stereogrid_odometry SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(stereogrid_odometry PRIVATE opencv_core opencv_imgproc opencv_calib3d opencv_video fmt::fmt)
add_subdirectory(io)

if(STEREOGRID_CONNECTED OR STEREOGRID_PYTHON)
  stereogrid_library(messages src/frame_messages.cpp)

  find_package(yaml-cpp REQUIRED)
  find_package(SQLite3 REQUIRED)
  find_package(ZLIB REQUIRED)
  pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
  pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
  stereogrid_library(mcap)
  target_link_libraries(stereogrid_mcap PRIVATE stereogrid_io fmt::fmt yaml-cpp SQLite::SQLite3 PkgConfig::ZSTD
                                                PkgConfig::LZ4 ZLIB::ZLIB)
endif()

if(STEREOGRID_CONNECTED)
  find_package(Boost 1.74 REQUIRED) # headers only
  find_package(nlohmann_json REQUIRED)
  stereogrid_library(server)
  # Beast and Asio take long to compile: together, and with -O1, which is as fast where bytes are only sent
  set_target_properties(stereogrid_server PROPERTIES UNITY_BUILD_BATCH_SIZE 0)
  target_compile_options(stereogrid_server PRIVATE $<$<CONFIG:Release,RelWithDebInfo>:-O1>)
  target_link_libraries(stereogrid_server PRIVATE $<BUILD_INTERFACE:Boost::headers>
                                                  $<BUILD_INTERFACE:nlohmann_json::nlohmann_json> Threads::Threads)
  if(STEREOGRID_SANITIZE MATCHES thread) # which does not understand fences; locks are enough here
    target_compile_definitions(stereogrid_server PRIVATE BOOST_ASIO_DISABLE_FENCED_BLOCK)
  endif()

  stereogrid_library(capture)
  target_link_libraries(stereogrid_capture PUBLIC stereogrid_io PRIVATE fmt::fmt Threads::Threads)
  target_compile_definitions(stereogrid_capture PRIVATE STEREOGRID_GSTREAMER=$<BOOL:${STEREOGRID_GSTREAMER}>)
  if(STEREOGRID_GSTREAMER)
    pkg_check_modules(GSTREAMER REQUIRED IMPORTED_TARGET gstreamer-1.0 gstreamer-app-1.0 gstreamer-video-1.0)
    target_link_libraries(stereogrid_capture PRIVATE PkgConfig::GSTREAMER)
  else()
    set_property(SOURCE ${PROJECT_SOURCE_DIR}/capture/src/gstreamer/camera.cpp ${PROJECT_SOURCE_DIR}/capture/src/gstreamer/pipeline.cpp
                 PROPERTY HEADER_FILE_ONLY ON)
  endif()
endif()

if(STEREOGRID_TOOL OR STEREOGRID_PYTHON)
  add_subdirectory(scenes)
  stereogrid_library(evaluation src/motion.cpp src/moving_objects.cpp src/obstacle_scores.cpp src/obstacle_truth.cpp
                                src/terrain.cpp)

  # not installed
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/rosbag/src/*.cpp)
  add_library(stereogrid_rosbag STATIC ${sources})
  stereogrid_unity(stereogrid_rosbag)
  target_include_directories(stereogrid_rosbag PUBLIC ${PROJECT_SOURCE_DIR}/rosbag/include PRIVATE ${PROJECT_SOURCE_DIR}/rosbag/src)
  target_include_directories(stereogrid_rosbag SYSTEM PUBLIC ${OpenCV_INCLUDE_DIRS})
  target_link_libraries(
    stereogrid_rosbag
    PRIVATE stereogrid_compiler fmt::fmt
    PUBLIC stereogrid::io stereogrid::mcap stereogrid::messages opencv_core)
endif()
