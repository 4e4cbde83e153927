#!/usr/bin/env bash
# Creates docs/performance.md: times of frames and of hot functions, and a comparison with other systems
# that are installed. Takes about ten minutes on an idle machine.
#
#   tools/scripts/performance.sh [--peer-frames=N] [DATA]
#
# DATA: folder of recorded sequences. N: number of frames for the other systems, default 200; all 1000
# frames of seven_scenes_kitchen take more than half an hour.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
peer_frames=200
if [[ ${1:-} == --peer-frames=* ]]; then
  peer_frames=${1#*=}
  [[ $peer_frames =~ ^[1-9][0-9]*$ ]] || { echo "error: --peer-frames is '$peer_frames', must be a positive number" >&2; exit 1; }
  shift
fi
data=${1:-${SURFIT_DATA_DIR:-../shared/data}}
benchmarks=build/release/tests/benchmarks
out=docs/performance.md
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

tools/scripts/build.sh release all benchmarks

# Adds a section with the output of a command.
table() {
  local title=$1
  shift
  echo "$title" >&2
  {
    echo "## $title"
    echo
    echo "    $ ${*//$scratch/out}"
    "$@" 2>>"$scratch/errors" | sed "s|$scratch|out|g; s/^/    /"
    echo
  } >>"$scratch/tables"
}

for sequence in seven_scenes_kitchen icl_office_kinect; do
  if [[ -d $data/$sequence ]]; then
    table "Frames of $sequence" "$benchmarks/frame_time" "$data/$sequence" "$scratch/run"
  fi
done
if [[ -d $data/seven_scenes_kitchen ]]; then
  table "1000 frames of seven_scenes_kitchen offered at 30 Hz" build/release/tools/surfit_slam \
    --sequence="$data/seven_scenes_kitchen" --output="$scratch/run" --pictures=false --offered_fps=30
  for solver in closed_form_ldlt ceres; do
    table "First 200 frames of seven_scenes_kitchen, solver $solver" \
      "$benchmarks/frame_time" "$data/seven_scenes_kitchen" "$scratch/run" 200 1e9 "$solver"
  done
  if [[ -x $benchmarks/peers/slam_peers ]]; then
    table "Comparison with other systems" "$benchmarks/peers/slam_peers" "$data/seven_scenes_kitchen" "$peer_frames"
  fi
  if [[ -x $benchmarks/peers/registration_peers ]]; then
    table "Comparison with registration libraries" \
      "$benchmarks/peers/registration_peers" "$data" 1
  fi
fi
table "Growing map" "$benchmarks/map_growth" "$scratch/out" 30 40

# The budget is written by hand, and kept.
budget=$(sed -n '/^## Budget$/,/^## Frames/p' "$out" | sed '/^## Frames/d')

{
  echo "# Performance"
  echo
  echo "Created by \`tools/scripts/performance.sh\` on $(date +%F), commit $(git rev-parse --short HEAD):"
  echo "$(nproc) processors, $(sed -n 's/^model name\s*: //p' /proc/cpuinfo | head -1)."
  echo
  if [[ -n $budget ]]; then
    echo "$budget"
    echo
  fi
  cat "$scratch/tables"
} >"$out"
echo "$out"
