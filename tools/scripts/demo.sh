#!/usr/bin/env bash
# Demo from a fresh clone: installs missing packages, builds the programs, simulates a room and runs
# surfit_slam.
#   demo.sh                   the simulated room
#   demo.sh --sequence=DIR    a recorded sequence
# All flags are passed to surfit_slam (see surfit_slam --help).
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
  # The room is simulated in another folder and then renamed: an interrupted run leaves no
  # incomplete room.
  rm -rf "$sequence.partial"
  "$tools/surfit_simulate" --output="$sequence.partial" --frames=200 --sensor=kinect
  mv "$sequence.partial" "$sequence"
fi

"$tools/surfit_slam" --sequence="$sequence" --output="$output" --report "$@"
echo "Pictures of the map and the trajectory: $output/*.png"
if [[ -e $output/report.html ]]; then
  echo "Report for a browser, with the map in 3D: $output/report.html"
fi
