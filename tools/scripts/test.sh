#!/usr/bin/env bash
# Builds and runs all tests: under AddressSanitizer and UBSan all but the slow ones, then in Release
# all but the sweeps. The sanitizers' test log is shown only if one fails; the last lines are ctest's
# summary of the Release run.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

bash "$scripts/install_dependencies.sh"
bash "$scripts/build.sh" asan
echo "Running the tests under asan"
if ! ctest --preset asan --parallel "$(nproc)" --quiet --output-log build/asan/tests.log </dev/null
then
  cat build/asan/tests.log
  exit 1
fi
bash "$scripts/build.sh" release
echo "Running the tests under release, without the sweeps over whole sequences, which take minutes"
ctest --preset release --parallel "$(nproc)" --label-exclude "sweep|fuzz" </dev/null
