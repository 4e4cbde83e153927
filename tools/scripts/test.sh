#!/usr/bin/env bash
# Builds and runs all tests: under AddressSanitizer and UBSan all but the slow ones, under
# ThreadSanitizer those labelled threads, then in Release all but the sweeps. The sanitizers' test
# logs are shown only if they fail; the last lines are ctest's summary of the Release run.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

test_quietly() {
  local preset=$1 log=build/$1/tests.log
  echo "Running the tests under $preset"
  if ! ctest --preset "$preset" --parallel "$(nproc)" --quiet --output-log "$log" </dev/null; then
    cat "$log"
    exit 1
  fi
}

bash "$scripts/install_dependencies.sh"
bash "$scripts/build.sh" asan
test_quietly asan
bash "$scripts/build.sh" tsan thread_tests
test_quietly tsan
bash "$scripts/build.sh" release
echo "Running the tests under release, without the sweeps over whole sequences, which take minutes:"
echo "  ctest --preset release --label-regex sweep"
ctest --preset release --parallel "$(nproc)" --label-exclude sweep </dev/null
