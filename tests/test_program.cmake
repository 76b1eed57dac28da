# SPDX-License-Identifier: MIT
# GoogleTest, and maxlogdet_test_program for the rooms.

# Debian's libgtest-dev holds the library for the host, and the sources for everything else.
set(gtest_sources /usr/src/googletest/googletest)
if(CMAKE_CROSSCOMPILING AND EXISTS ${gtest_sources})
  add_library(maxlogdet_gtest STATIC EXCLUDE_FROM_ALL ${gtest_sources}/src/gtest-all.cc)
  target_include_directories(maxlogdet_gtest SYSTEM PUBLIC ${gtest_sources}/include PRIVATE ${gtest_sources})
  target_compile_features(maxlogdet_gtest PUBLIC cxx_std_17)
  add_library(GTest::gtest ALIAS maxlogdet_gtest)
else()
  maxlogdet_require(GTest libgtest-dev MAXLOGDET_BUILD_TESTS)
endif()
include(GoogleTest)

function(maxlogdet_test_program name)  # NAME [LABEL LABEL] SOURCE...
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL" "")
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  maxlogdet_compile_options(${name})
  maxlogdet_hardly_optimize(${name})
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF)
  maxlogdet_link_first(${name} maxlogdet_test_support maxlogdet_frames)
  target_link_libraries(${name} PRIVATE maxlogdet_test_main)
  target_precompile_headers(${name} REUSE_FROM maxlogdet_test_main)
  set(labels)
  if(arg_LABEL)
    set(labels LABELS ${arg_LABEL})
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600 ${labels})
endfunction()
