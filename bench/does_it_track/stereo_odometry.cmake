# SPDX-License-Identifier: MIT
# A library of everything except the command line and main(), for the program and its tests. If OpenCV or yaml-cpp is
# missing, stereo_odometry_FOUND is false and there is no library.
find_package(OpenCV QUIET COMPONENTS core imgproc imgcodecs features2d calib3d video)
find_package(yaml-cpp QUIET)
set(stereo_odometry_FOUND FALSE)
if(OpenCV_FOUND AND yaml-cpp_FOUND)
  set(stereo_odometry_FOUND TRUE)
  set(here ${CMAKE_CURRENT_LIST_DIR})
  add_library(maxlogdet_stereo_odometry STATIC
    ${here}/active_matching.cpp ${here}/dataset.cpp ${here}/depth.cpp ${here}/euroc.cpp ${here}/features.cpp
    ${here}/kitti.cpp ${here}/local_map.cpp ${here}/matcher.cpp ${here}/matching_comparison.cpp
    ${here}/projection_search.cpp ${here}/report.cpp ${here}/same_frame.cpp ${here}/tracker.cpp ${here}/tum.cpp)
  maxlogdet_compile_options(maxlogdet_stereo_odometry)
  maxlogdet_sanitize_less(maxlogdet_stereo_odometry)
  target_compile_features(maxlogdet_stereo_odometry PUBLIC cxx_std_17)
  target_precompile_headers(maxlogdet_stereo_odometry REUSE_FROM maxlogdet_tracking)
  set_target_properties(maxlogdet_stereo_odometry PROPERTIES CXX_EXTENSIONS OFF)
  target_include_directories(maxlogdet_stereo_odometry PUBLIC ${MAXLOGDET_ROOT})
  target_include_directories(maxlogdet_stereo_odometry SYSTEM PUBLIC ${OpenCV_INCLUDE_DIRS})
  target_link_libraries(maxlogdet_stereo_odometry PUBLIC maxlogdet_tracking ${OpenCV_LIBS} PRIVATE ${YAML_CPP_LIBRARIES})
endif()
