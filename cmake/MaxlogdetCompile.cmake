# SPDX-License-Identifier: MIT

get_filename_component(maxlogdet_root ${CMAKE_CURRENT_LIST_DIR}/.. ABSOLUTE)
set(MAXLOGDET_ROOT ${maxlogdet_root} CACHE INTERNAL "The sources")  # for every folder that calls what follows

# Compile options of all our own targets; private, so that none reaches a consumer.
function(maxlogdet_compile_options target)
  target_include_directories(${target} PRIVATE ${MAXLOGDET_ROOT})
  if(MAXLOGDET_IS_TOP_LEVEL)  # inside another project, that one chooses
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
    if(CMAKE_CXX_COMPILER_ID MATCHES Clang)  # what it sees here: docs/trust.md
      target_compile_options(${target} PRIVATE -Wthread-safety)
    endif()
    if(MAXLOGDET_WERROR)
      target_compile_options(${target} PRIVATE -Werror)
    endif()
  endif()
  if(MAXLOGDET_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${MAXLOGDET_SANITIZE} -fno-omit-frame-pointer
                                             -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${MAXLOGDET_SANITIZE})
  endif()
  # The answer is the same on every machine because every operation is rounded as IEEE 754 says, one by one; the flags
  # that a surrounding project may set for all its code must not take that away.
  target_compile_options(${target} PRIVATE -fno-fast-math -ffp-contract=off)
endfunction()

# What UndefinedBehaviorSanitizer does in the library alone: elsewhere, in the code of Eigen above all, these make half of
# the time that it takes to compile.
function(maxlogdet_sanitize_less target)
  if(MAXLOGDET_SANITIZE MATCHES undefined)
    target_compile_options(${target} PRIVATE -fno-sanitize=null,alignment,object-size,vptr)
  endif()
endfunction()

# For what takes longer to compile than to run, as the tests' oracles with their Eigen.
function(maxlogdet_compile_quickly target)
  maxlogdet_sanitize_less(${target})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(MAXLOGDET_SANITIZE MATCHES fuzzer)
    target_compile_options(${target} PRIVATE -fno-sanitize=fuzzer-no-link)
  endif()
endfunction()

# For programs of CLI11 and JSON, and tests' own code: under sanitizers not optimized at all by clang, which takes it half
# of the time or less; gcc is hardly faster.
function(maxlogdet_hardly_optimize target)
  maxlogdet_compile_quickly(${target})
  if(MAXLOGDET_SANITIZE AND CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()

# Of an inline function that several objects have, the linker takes the first it sees: for programs that are not
# optimized, that of LIBRARY..., which are.
function(maxlogdet_link_first target)  # TARGET LIBRARY...
  list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE archives)
  list(JOIN archives "," archives)
  target_link_libraries(${target} PRIVATE ${ARGN})
  target_link_options(${target} PRIVATE LINKER:--whole-archive,${archives},--no-whole-archive)
endfunction()

# What most files of sim/, cli/ and tests/ include, Eigen above all, parsed once for a target: half of the time that they
# take to compile. -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON does without.
set(maxlogdet_common_headers
  <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory> <numeric>
  <optional> <set> <sstream> <stdexcept> <string> <utility> <vector>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/QR>)

# maxlogdet_require(PACKAGE DEBIAN_PACKAGE OPTION...): find_package for optional parts; says what to install, or how to do
# without.
macro(maxlogdet_require package debian_package)
  find_package(${package} QUIET)
  if(NOT ${package}_FOUND)
    string(REPLACE ";" "=OFF -D" maxlogdet_options "${ARGN}")
    message(FATAL_ERROR "${package} is missing. On Debian: apt-get install ${debian_package} (ci/install_packages test "
                        "installs everything). To do without it: -D${maxlogdet_options}=OFF")
  endif()
endmacro()
