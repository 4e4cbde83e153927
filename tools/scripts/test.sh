#!/usr/bin/env bash
# What CI runs: format and clang-tidy of what changed; the tests under AddressSanitizer and UBSan but
# for the slow ones; all but the sweeps in Release. The sanitizers' log is shown only where a test
# fails; the last lines are ctest's summary in Release.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

bash "$scripts/install_dependencies.sh"
bash "$scripts/check_changes.sh"
bash "$scripts/build.sh" asan
echo "Running the tests under asan"
# Twice where it fails: LeakSanitizer itself has crashed when a passed program ended ("Tracer caught signal").
if ! ctest --preset asan --parallel "$(nproc)" --repeat until-pass:2 --quiet \
  --output-log build/asan/tests.log </dev/null
then
  cat build/asan/tests.log
  exit 1
fi
bash "$scripts/build.sh" release
echo "Running the tests under release, without the sweeps over whole sequences, which take minutes"
ctest --preset release --parallel "$(nproc)" --label-exclude "sweep|fuzz" </dev/null
