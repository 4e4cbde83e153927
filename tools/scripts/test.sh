#!/usr/bin/env bash
# What CI runs: format and clang-tidy of what changed, and in Release all tests but those that take
# minutes each. The last lines are ctest's summary.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

bash "$scripts/install_dependencies.sh"
bash "$scripts/check_changes.sh"
bash "$scripts/build.sh" release
echo "Running the tests, without sweeps over whole sequences, scans on Slurm and what else takes minutes"
ctest --preset release --parallel "$(nproc)" --label-exclude "sweep|fuzz|soak|cluster|benchmark" </dev/null
