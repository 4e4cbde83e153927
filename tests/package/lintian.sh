#!/usr/bin/env bash
# Checks the Debian packages of a build with lintian: lintian.sh BUILD
# BUILD: build folder of the preset `package` after `cpack`. Fails on errors and warnings without an
# override, and on unused overrides.
set -euo pipefail
debs=("$1"/*.deb)
[[ -e ${debs[0]} ]] || { echo "error: no packages in $1: run cpack there" >&2; exit 1; }
lintian --fail-on=error,warning --tag-display-limit=0 "${debs[@]}"
lintian --fail-on=info --tags=unused-override,mismatched-override "${debs[@]}"
