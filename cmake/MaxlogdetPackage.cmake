# SPDX-License-Identifier: MIT

# Read by ROS 2 workspaces only, which look for it in the prefix of a package.
install(FILES ${PROJECT_SOURCE_DIR}/package.xml DESTINATION share/maxlogdet)
file(WRITE ${PROJECT_BINARY_DIR}/ament_index_marker "")
install(FILES ${PROJECT_BINARY_DIR}/ament_index_marker
  DESTINATION share/ament_index/resource_index/packages RENAME maxlogdet)
