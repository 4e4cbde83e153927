#!/usr/bin/env bash
# Configures and builds one preset on all cores: build.sh <preset> [target...]
# In CI (environment variable CI set) warnings are errors.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
preset=$1
shift

# ccache hits do not depend on the path of the source folder.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1
cd "$root"
cmake --preset "$preset" --log-level=WARNING ${CI:+-DCMAKE_COMPILE_WARNING_AS_ERROR=ON}
cmake --build --preset "$preset" --parallel "$(nproc)" ${1:+--target "$@"}
