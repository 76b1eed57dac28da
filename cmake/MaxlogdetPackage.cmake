# SPDX-License-Identifier: MIT

# Read by ROS 2 workspaces only, which look for it in the prefix of a package.
install(FILES ${PROJECT_SOURCE_DIR}/package.xml DESTINATION share/maxlogdet)
file(WRITE ${PROJECT_BINARY_DIR}/ament_index_marker "")
install(FILES ${PROJECT_BINARY_DIR}/ament_index_marker
  DESTINATION share/ament_index/resource_index/packages RENAME maxlogdet)

# The target `package`: Debian's libmaxlogdet-dev. Only in a build configured as ci/package does: with the prefix /usr
# libraries go to Debian's multiarch folder, and the program is not a development file.
if(NOT MAXLOGDET_IS_TOP_LEVEL OR NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr" OR MAXLOGDET_BUILD_PROGRAM
   OR CMAKE_CROSSCOMPILING)
  return()
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME libmaxlogdet-dev)
# The format requires an address, and there is none: RFC 2606 reserves `.invalid` for that. As in package.xml.
set(CPACK_PACKAGE_CONTACT "The maxlogdet authors <nobody@maxlogdet.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "feature selection for camera-pose least squares (development files)")
set(CPACK_PACKAGE_DESCRIPTION
"A visual SLAM tracker matches thousands of features and needs only some of
them. maxlogdet picks, in tens of microseconds, those that keep the pose
estimation best conditioned (Max-logDet).
.
This package holds the headers, the static libraries, and what CMake's
find_package, pkg-config and colcon need to find them. The library
libmaxlogdet_tbb.a needs libtbb-dev, the headers maxlogdet/eigen.hpp and
sophus.hpp need libeigen3-dev, opencv.hpp needs libopencv-core-dev; the rest
needs no other package.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, libtbb-dev")
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian_docs.cmake)
set(CPACK_MAXLOGDET_COPYRIGHT ${PROJECT_SOURCE_DIR}/cmake/debian_copyright)
include(CPack)
