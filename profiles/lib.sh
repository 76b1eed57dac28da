# SPDX-License-Identifier: MIT
# Functions of the scripts beside it, which run from the root of the project; sourced after tools/lib.sh.
build=build/profile
strategies=(greedy lazy_greedy stochastic_greedy)

# build_profile TARGET: builds it in $build, in Release mode with symbols.
build_profile() {
  tools/install_packages test
  tools/install_packages profile
  mkdir -p "$build"
  if ! run_logged "building $1" "$build/build.log" build_target "$1"; then
    tail -40 "$build/build.log" >&2
    exit 1
  fi
}
build_target() {
  configure_release "$build" -DMAXLOGDET_BUILD_BENCHMARKS=ON -DCMAKE_CXX_FLAGS=-g &&
    cmake --build "$build" --target "$1"
}
