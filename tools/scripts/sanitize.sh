#!/usr/bin/env bash
# Runs the tests except slow tests with AddressSanitizer and UBSan, and the thread tests with
# ThreadSanitizer. Takes two builds, and half an hour on two cores. Run it after changes of file readers,
# memory management or threads, and before each release. Logs of passed tests are not shown.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

bash "$scripts/install_dependencies.sh"

# sanitized PRESET [CTEST-OPTION...]: runs the tests of a preset that is built.
sanitized() {
  local preset=$1
  shift
  echo "Running the tests under $preset"
  if ! ctest --preset "$preset" --parallel "$(nproc)" --quiet --output-log "build/$preset/tests.log" "$@" </dev/null
  then
    cat "build/$preset/tests.log"
    exit 1
  fi
}
bash "$scripts/build.sh" asan
# Repeated after a failure: LeakSanitizer sometimes crashes at the end of a passed test ("Tracer
# caught signal").
sanitized asan --repeat until-pass:2
bash "$scripts/build.sh" tsan thread_tests
sanitized tsan
