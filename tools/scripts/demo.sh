#!/usr/bin/env bash
# From a fresh clone to a fused room: installs what is missing, builds the programs, simulates a
# room and runs surfit_slam on it.
#   demo.sh                   the simulated room
#   demo.sh --sequence=DIR    a recorded sequence instead
# All flags go to surfit_slam (see surfit_slam --help).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tools=$root/build/release/tools

sequence=$root/out/room
output=$root/out/demo
for flag in "$@"; do
  case $flag in
    --sequence=*) sequence=${flag#*=} ;;
    --output=*) output=${flag#*=} ;;
  esac
done

bash "$root/tools/scripts/install_dependencies.sh" programs
bash "$root/tools/scripts/build.sh" release surfit_simulate surfit_slam

if [[ $sequence == "$root/out/room" && ! -d $sequence ]]; then
  # Simulated beside its place and moved there when whole, so that an interrupted run leaves none.
  rm -rf "$sequence.partial"
  "$tools/surfit_simulate" --output="$sequence.partial" --frames=200 --sensor=kinect
  mv "$sequence.partial" "$sequence"
fi

"$tools/surfit_slam" --sequence="$sequence" --output="$output" --report "$@"
echo "The pictures of the map and the trajectory: $output/*.png"
if [[ -e $output/report.html ]]; then
  echo "All of it in a browser, map in 3D: $output/report.html"
fi
