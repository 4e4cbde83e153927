#!/usr/bin/env bash
# The tests but for the slow ones under AddressSanitizer and UBSan, those of threads under
# ThreadSanitizer: two builds more, half an hour on two cores. For changes of readers, of memory and
# of threads, and before each release. A log is shown only where a test fails.
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
# Twice where it fails: LeakSanitizer itself has crashed when a passed program ended ("Tracer caught signal").
sanitized asan --repeat until-pass:2
bash "$scripts/build.sh" tsan thread_tests
sanitized tsan
