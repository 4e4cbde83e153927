#!/usr/bin/env bash
# Creates docs/accuracy.md: the ATE without each part of tracking and mapping, or with a part that
# is off by default. Takes about half an hour on two idle cores. The errors do not depend on the
# load.
#
#   tools/scripts/accuracy.sh [--quick] [--tools=DIR] [--output=FILE] [DATA]
#
#   --quick    two rows with two tiny simulated rooms, to test the script
#   --tools    folder of the programs; default: they are built
#   DATA       folder of recorded sequences; missing sequences are skipped
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
data=${SURFIT_DATA_DIR:-$root/../shared/data}
out=$root/docs/accuracy.md
tools= quick=
for argument in "$@"; do
  case $argument in
    --quick) quick=1 ;;
    --tools=*) tools=${argument#*=} ;;
    --output=*) out=${argument#*=} ;;
    -*) echo "error: unknown flag $argument" >&2 && exit 1 ;;
    *) data=$argument ;;
  esac
done
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

if [[ -z $tools ]]; then
  "$root/tools/scripts/build.sh" release surfit_slam surfit_simulate
  tools=$root/build/release/tools
fi

# The rows: a name, and flags of surfit_slam.
rows=(
  "default|"
  "no calibration|--nocalibrate"
  "point-to-plane residual|--residual=point_to_plane"
  "plane-to-plane residual (GICP)|--residual=plane_to_plane"
  "point-to-point residual|--residual=point_to_point"
  "photometric residuals|--photometric_weight=0.01"
  "no robust kernel|--kernel=none"
  "a tenth of the depth noise|--inverse_depth_sigma=0.0002"
  "no normal gate|--max_normal_angle_deg=0"
  "every frame fused, with its own view|--map_period=1"
  "loop closure|--loop_closure"
  "last pose as prediction|--motion_model=constant_pose"
  "predicted rotation by images|--motion_model=so3"
  "every third frame|--stride=3"
  "every third frame, last pose as prediction|--stride=3 --motion_model=constant_pose"
  "every third frame, predicted rotation by images|--stride=3 --motion_model=so3"
  "every third frame, point-to-plane residual|--stride=3 --residual=point_to_plane"
  "frame to frame|--tracking=frame_to_frame"
  "frame to frame, point-to-plane residual|--tracking=frame_to_frame --residual=point_to_plane"
)
recorded=(tum_fr1_desk "seven_scenes_kitchen --last=199" icl_office icl_office_kinect)
seeds=(1 2 3 4 5) frames=100 downsample=2
if [[ $quick ]]; then
  rows=("${rows[0]}" "frame to frame|--tracking=frame_to_frame")
  recorded=()
  seeds=(1 2) frames=12 downsample=8
fi

for seed in "${seeds[@]}"; do
  echo "simulating room $seed" >&2
  "$tools/surfit_simulate" --output="$scratch/room$seed" --seed="$seed" --frames="$frames" \
    --downsample="$downsample" --sensor=kinect >>"$scratch/log" 2>&1
done

# Figures of a run: ATE in mm or none, number of lost frames, CPU time in s.
run() {
  local code=0 TIMEFORMAT='%U %S'
  { time "$tools/surfit_slam" --output="$scratch/run" --nopictures "$@" >>"$scratch/log" 2>&1; } \
    2>"$scratch/time" || code=$?
  if ((code != 0 && code != 2)); then  # 2: tracking failed
    tail -3 "$scratch/log" >&2
    exit 1
  fi
  awk -F '[:,]' -v cpu_s="$(awk '{ print $1 + $2 }' "$scratch/time")" '
    /"ate_rmse_m"/ { ate = $2 ~ /null/ ? "none" : sprintf("%.2f", 1e3 * $2) }
    /"frames_lost"/ { lost = $2 + 0 }
    END { print ate, lost, cpu_s }' "$scratch/run/summary.json"
}

with_losses() { # ATE, lost frames
  if (($2 > 0)); then echo "$1 ($2 lost)"; else echo "$1"; fi
}

header="| part |" rule="|---|" default_cpu_s=
for sequence in "${recorded[@]}"; do
  [[ -d $data/${sequence%% *} ]] || continue
  header+=" $sequence |" rule+="---|"
done
header+=" simulated rooms, mean | worst | CPU time |" rule+="---|---|---|"

table=$header$'\n'$rule
for row in "${rows[@]}"; do
  name=${row%%|*} flags=${row#*|}
  echo "$name" >&2
  line="| $name${flags:+ \`$flags\`} |" sum_cpu_s=0
  for sequence in "${recorded[@]}"; do
    [[ -d $data/${sequence%% *} ]] || continue
    # shellcheck disable=SC2086  # several flags
    figures=$(run --sequence="$data/"$sequence $flags)
    read -r ate lost cpu_s <<<"$figures"
    line+=" $(with_losses "$ate" "$lost") |"
    sum_cpu_s=$(awk "BEGIN { print $sum_cpu_s + $cpu_s }")
  done
  ates= all_lost=0
  for seed in "${seeds[@]}"; do
    # shellcheck disable=SC2086
    figures=$(run --sequence="$scratch/room$seed" $flags)
    read -r ate lost cpu_s <<<"$figures"
    ates+="$ate " all_lost=$((all_lost + lost))
    sum_cpu_s=$(awk "BEGIN { print $sum_cpu_s + $cpu_s }")
  done
  rooms=$(awk '/none/ { print "none none"; exit }
               { for (i = 1; i <= NF; ++i) { sum += $i; if ($i > worst) worst = $i }
                 printf "%.2f %.2f", sum / NF, worst }' <<<"$ates")
  default_cpu_s=${default_cpu_s:-$sum_cpu_s}
  line+=" $(with_losses "${rooms% *}" "$all_lost") | ${rooms#* } |"
  table+=$'\n'"$line $(awk "BEGIN { printf \"%.2f\", $sum_cpu_s / $default_cpu_s }") |"
done

kitchen=
if [[ ! $quick && -d $data/seven_scenes_kitchen ]]; then
  echo "all frames of seven_scenes_kitchen" >&2
  figures=$(run --sequence="$data/seven_scenes_kitchen")
  read -r ate lost cpu_s <<<"$figures"
  kitchen="All frames of seven_scenes_kitchen with the defaults: $(with_losses "$ate" "$lost") mm."
fi

{
  echo "# Accuracy"
  echo
  echo "Created by \`tools/scripts/accuracy.sh${quick:+ --quick}\` on $(date +%F), commit" \
    "$(git -C "$root" rev-parse --short HEAD):"
  echo "$(nproc) processors, $(sed -n 's/^model name\s*: //p' /proc/cpuinfo | head -1)."
  echo
  echo "ATE RMSE in mm with the given flags; other flags have their defaults. Simulated rooms:"
  echo "\`surfit_simulate --sensor=kinect --downsample=$downsample --frames=$frames\`," \
    "seeds ${seeds[*]}. CPU time is the"
  echo "sum over all processors, relative to the default."
  echo
  echo "$table"
  echo
  echo "${kitchen:-}"
} >"$out"
cat "$out"
