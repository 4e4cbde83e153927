#!/usr/bin/env bash
# What CI runs: format and clang-tidy of what changed; the tests under AddressSanitizer and UBSan but
# for the slow ones; the tests of threads under ThreadSanitizer; all but the sweeps in Release. A
# sanitizer's log is shown only where a test fails; the last lines are ctest's summary in Release.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

# A preset's tests, which end the script where one fails.
run_tests() {
  local preset=$1
  echo "Running the tests under $preset"
  if ! ctest --preset "$preset" --parallel "$(nproc)" --quiet --output-log "build/$preset/tests.log" \
    </dev/null; then
    cat "build/$preset/tests.log"
    exit 1
  fi
}

bash "$scripts/install_dependencies.sh"
bash "$scripts/check_changes.sh"
bash "$scripts/build.sh" asan
run_tests asan
bash "$scripts/build.sh" tsan thread_tests
run_tests tsan
bash "$scripts/build.sh" release
echo "Running the tests under release, without the sweeps over whole sequences, which take minutes"
ctest --preset release --parallel "$(nproc)" --label-exclude "sweep|fuzz" </dev/null
