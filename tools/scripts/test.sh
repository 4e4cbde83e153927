#!/usr/bin/env bash
# What CI runs: format and clang-tidy of what changed; the tests under AddressSanitizer and UBSan but
# for the slow ones; those of threads under ThreadSanitizer; all but the sweeps in Release. The
# sanitizers' logs are shown only where a test fails; the last lines are ctest's summary in Release.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

bash "$scripts/install_dependencies.sh"
bash "$scripts/check_changes.sh"

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
bash "$scripts/build.sh" release
echo "Running the tests under release, without those that take minutes: sweeps over whole sequences, scans on Slurm"
ctest --preset release --parallel "$(nproc)" --label-exclude "sweep|fuzz|soak|cluster" </dev/null
