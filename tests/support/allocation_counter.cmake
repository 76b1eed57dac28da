# SPDX-License-Identifier: MIT
# Replaces malloc: only for the tests and benchmarks that count allocations. Apart from the room's CMakeLists.txt because
# benchmarks are built without the tests, too.
include(${PROJECT_SOURCE_DIR}/cmake/MaxlogdetCompile.cmake)
add_library(maxlogdet_allocation_counter OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_LIST_DIR}/allocation_counter.cpp)
maxlogdet_compile_options(maxlogdet_allocation_counter)
target_compile_features(maxlogdet_allocation_counter PUBLIC cxx_std_17)
set_target_properties(maxlogdet_allocation_counter PROPERTIES CXX_EXTENSIONS OFF)
