#!/usr/bin/env bash
# CI: checks format and clang-tidy of changed files, builds Release and runs all tests except sweeps,
# fuzzing, the soak, the cluster test and benchmarks. The last lines are the summary of ctest.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
cd "$root"

bash "$scripts/install_dependencies.sh"
bash "$scripts/check_changes.sh"
bash "$scripts/build.sh" release
echo "Running the tests, except sweeps over whole sequences, scans on Slurm, benchmarks and other long tests"
ctest --preset release --parallel "$(nproc)" --label-exclude "sweep|fuzz|soak|cluster|benchmark" </dev/null
