#!/usr/bin/env bash
# Cross-compiles for 64-bit ARM, where SIMD lanes are NEON instructions. Runs the fast tests of
# vectorised code in an emulator (qemu-user). Installs the required packages.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scripts=$root/tools/scripts
rooms=(core cost_functions registration mapping)

bash "$scripts/install_dependencies.sh"
bash "$scripts/install_dependencies.sh" arm
bash "$scripts/build.sh" arm "${rooms[@]/#/test_}"
names=$(IFS='|'; echo "${rooms[*]}")
cd "$root"
ctest --preset arm --parallel "$(nproc)" --tests-regex "^($names)\." --exclude-regex "\.patterns$" \
  --label-exclude "slow|sweep|threads" </dev/null
