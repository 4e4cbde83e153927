#!/usr/bin/env bash
# Has lintian check the Debian packages of a build: lintian.sh BUILD
# BUILD is a build of the preset `package` after `cpack`. Fails with an error or a warning that no
# override gives a reason for, and with an override that nothing needs.
set -euo pipefail
debs=("$1"/*.deb)
[[ -e ${debs[0]} ]] || { echo "error: no packages in $1: run cpack there" >&2; exit 1; }
lintian --fail-on=error,warning --tag-display-limit=0 "${debs[@]}"
lintian --fail-on=info --tags=unused-override,mismatched-override "${debs[@]}"
