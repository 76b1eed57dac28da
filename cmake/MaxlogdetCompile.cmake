# SPDX-License-Identifier: MIT

get_filename_component(maxlogdet_root ${CMAKE_CURRENT_LIST_DIR}/.. ABSOLUTE)
set(MAXLOGDET_ROOT ${maxlogdet_root} CACHE INTERNAL "The sources")  # for every folder that calls the functions below

# Compile options of all our own targets; private, so that none reaches a consumer.
function(maxlogdet_compile_options target)
  target_include_directories(${target} PRIVATE ${MAXLOGDET_ROOT})
  if(MAXLOGDET_IS_TOP_LEVEL)  # inside another project, that project chooses
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
    if(CMAKE_CXX_COMPILER_ID MATCHES Clang)  # what it checks: docs/trust.md
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
  # The answer is the same on every machine because every operation is rounded by itself, as IEEE 754 says; flags of a
  # parent project must not change that.
  target_compile_options(${target} PRIVATE -fno-fast-math -ffp-contract=off)
endfunction()

# Turns off checks of UndefinedBehaviorSanitizer that only the library keeps: elsewhere, in Eigen above all, they take
# half of the compile time.
function(maxlogdet_sanitize_less target)
  if(MAXLOGDET_SANITIZE MATCHES undefined)
    target_compile_options(${target} PRIVATE -fno-sanitize=null,alignment,object-size,vptr)
  endif()
endfunction()

# For targets that take longer to compile than to run, such as the tests' oracles with Eigen.
function(maxlogdet_compile_quickly target)
  maxlogdet_sanitize_less(${target})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(MAXLOGDET_SANITIZE MATCHES fuzzer)
    target_compile_options(${target} PRIVATE -fno-sanitize=fuzzer-no-link)
  endif()
endfunction()

# For programs with CLI11 and JSON, and test code: not optimised under sanitizers by clang, which then takes at most
# half of the time; gcc is hardly faster.
function(maxlogdet_hardly_optimize target)
  maxlogdet_compile_quickly(${target})
  if(MAXLOGDET_SANITIZE AND CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()

# The linker takes the first definition of an inline function that it sees: for programs that are not optimised, that of
# LIBRARY..., which are.
function(maxlogdet_link_first target)  # TARGET LIBRARY...
  list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE archives)
  list(JOIN archives "," archives)
  target_link_libraries(${target} PRIVATE ${ARGN})
  target_link_options(${target} PRIVATE LINKER:--whole-archive,${archives},--no-whole-archive)
endfunction()

# Common headers of bench/world/, cli/ and tests/, Eigen above all, precompiled once per target, which halves the compile time.
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON turns this off.
set(maxlogdet_common_headers
  <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory> <numeric>
  <optional> <set> <sstream> <stdexcept> <string> <utility> <vector>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/QR>)

# maxlogdet_require(PACKAGE DEBIAN_PACKAGE OPTION...): find_package for optional parts; the error says what to install,
# and which OPTION turns the part off.
macro(maxlogdet_require package debian_package)
  find_package(${package} QUIET)
  if(NOT ${package}_FOUND)
    string(REPLACE ";" "=OFF -D" maxlogdet_options "${ARGN}")
    message(FATAL_ERROR "${package} is missing. On Debian: apt-get install ${debian_package} (tools/install_packages test "
                        "installs everything). To do without it: -D${maxlogdet_options}=OFF")
  endif()
endmacro()
