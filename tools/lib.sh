# SPDX-License-Identifier: MIT
# Shared by the scripts beside it; sourced.

# run_python SCRIPT ARGUMENT...: runs a Python script of the project, which may import the package in tools/. From the
# root of the project.
run_python() { PYTHONPATH=tools PYTHONDONTWRITEBYTECODE=1 python3 "$@"; }

# run_logged LABEL LOG COMMAND...: runs COMMAND with its output in LOG, and returns its exit code. On a terminal, a
# command that takes over two seconds shows the last line of LOG behind LABEL until it ends, unless $quiet says not to.
run_logged() {
  local label=$1 log=$2 ticker='' status=0
  shift 2
  : >"$log"
  if [ -t 1 ] && [ "${quiet:-no}" = no ]; then
    show_progress "$label" "$log" &
    ticker=$!
  fi
  "$@" >"$log" 2>&1 </dev/null || status=$?
  if [ -n "$ticker" ]; then
    kill "$ticker" 2>/dev/null || true
    wait "$ticker" 2>/dev/null || true
    printf '\r\033[K'
  fi
  return "$status"
}

# step LABEL LOG COMMAND...: run_logged; if it fails, the end of the log, and exit with its code.
step() {
  local status=0
  run_logged "$@" || status=$?
  [ "$status" -eq 0 ] && return
  tail -n 30 "$2" >&2
  echo "$1 failed; all of it is in $2" >&2
  exit "$status"
}

# configure_release FOLDER CMAKE_OPTION...: a release build in FOLDER, without tests, benchmarks and the Python module
# unless options ask.
configure_release() {
  local build=$1
  shift
  cmake --preset release -B "$build" -DMAXLOGDET_BUILD_TESTS=OFF -DMAXLOGDET_BUILD_BENCHMARKS=OFF \
    -DMAXLOGDET_BUILD_PYTHON=OFF "$@"
}

# build_benchmarks FOLDER TARGET...: the release build that all rooms of bench/ with programs of their own share.
build_benchmarks() {
  configure_release "$1" -DMAXLOGDET_BUILD_TESTS=ON -DMAXLOGDET_BUILD_BENCHMARKS=ON && cmake --build "$1" --target "${@:2}"
}

show_progress() {
  local start=$SECONDS
  sleep 2
  while kill -0 $$ 2>/dev/null; do  # as long as the script lives
    printf '\r\033[K%-34s %3d s  %s' "$1" $((SECONDS - start)) "$(tail -n 1 "$2" | tr -d '\r' | cut -c1-60)"
    sleep 0.5
  done
}
