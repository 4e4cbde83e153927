#!/usr/bin/env bash
# A scan on a local Slurm cluster with failing nodes:
#   slurm_test.sh FOLDER_OF_PROGRAMS
# Takes a few minutes. Exits with code 77 if packages are missing
# (tools/scripts/install_dependencies.sh cluster), or without root permissions.
set -euo pipefail
programs=$1
# shellcheck source=slurm_cluster.sh
source "$(dirname "${BASH_SOURCE[0]}")/slurm_cluster.sh"
PATH=$PATH:/usr/sbin
for program in "${slurm_programs[@]}" setpriv snakemake; do
  command -v "$program" >/dev/null || { echo "skipped: there is no $program"; exit 77; }
done
[[ $(id -u) == 0 ]] || { echo "skipped: only root can start the nodes of a Slurm"; exit 77; }

folder=$(mktemp -d)
running=()
clean_up() {
  ((!${#running[@]})) || kill "${running[@]}" 2>/dev/null || true
  stop_cluster
  # A killed job may still be writing.
  rm -rf "$folder" 2>/dev/null || { sleep 2; rm -rf "$folder"; }
}
trap clean_up EXIT
fail() {
  echo "error: $1" >&2
  tail -n 40 "$folder"/*.log "$folder"/*.txt "$folder"/cluster/*.log >&2 || true
  exit 1
}

scan() {  # scan NAME FLAG...
  exec "$programs/surfit_scan" --sequence="$folder/rooms" --output="$folder/$1" --fragment_frames=75,20 \
    "${@:2}" >"$folder/$1.txt" 2>&1
}
digest() { grep '"digest"' "$folder/$1/summary.json"; }
receipts() { find "$folder/$1/jobs" -name '*.json' "${@:2}" | wc -l; }
submitted() { grep -c 'with external jobid' "$folder/$1.txt"; }
runs_a() { node_jobs "$1" | grep -q " surfit-$2$"; }  # runs_a NODE RULE
has_done_a() { [[ $(receipts failing -name "$1_*") != 0 ]]; }
common() { comm -12 <(sort <<<"$1") <(sort <<<"$2") | grep . || true; }  # lines of both

echo "A scan on this machine"
"$programs/surfit_simulate" --output="$folder/rooms" --scene=three_rooms --frames=300 --downsample=2 \
  --surface_grid_m=0.1 >"$folder/simulate.txt" 2>&1
(scan local --cores=2) || fail "the scan on this machine failed"

echo "A scan on a Slurm cluster with two nodes"
start_cluster "$folder/cluster"
(scan slurm --profile=slurm) || fail "the scan by Slurm failed"
[[ $(digest slurm) == "$(digest local)" ]] || fail "digest $(digest slurm) with Slurm, $(digest local) without"
jobs=$(receipts slurm)
[[ $jobs == "$(receipts local)" ]] || fail "$jobs jobs with Slurm, $(receipts local) without"
[[ $(submitted slurm) == "$jobs" ]] || fail "$(submitted slurm) jobs were submitted, not $jobs"
for node in "${nodes[@]}"; do
  cluster_jobs | grep -q " JobState=COMPLETED .* NodeList=$node " || fail "$node has done no job"
done
[[ -z $(restarted_jobs) ]] || fail "jobs were restarted without a node failure"

echo "A scan with failing nodes"
(scan failing --profile=slurm) &
running=("$!")
wait_until "a fragment on node2" runs_a node2 fragment
lost=$(node_jobs node2)
fail_node node2
echo "  node2 is set down with ${lost//$'\n'/, }"
wait_until "a fragment to be done" has_done_a fragment
resume_node node2
wait_until "a tile on node1" runs_a node1 tile
touch "$folder/killed"
kill_node node1
lost_later=$(node_jobs node1)  # the cluster detects the failure after some seconds
echo "  node1 is killed with ${lost_later//$'\n'/, }"
wait_until "node1 to be missed" node_is node1 DOWN
wait "${running[0]}" || fail "the scan with failing nodes failed"
running=()
[[ $(digest failing) == "$(digest local)" ]] || fail "digest $(digest failing) with failing nodes, $(digest local) without"
# Slurm has restarted only jobs of failed nodes. One of these jobs may have completed before.
restarted=$(restarted_jobs)
echo "  restarted: ${restarted//$'\n'/, }"
[[ -n $(common "$restarted" "$lost") ]] || fail "no job of node2 was restarted"
[[ -n $(common "$restarted" "$lost_later") ]] || fail "no job of node1 was restarted"
[[ $(common "$restarted" "$lost"$'\n'"$lost_later") == $(sort <<<"$restarted") ]] ||
  fail "jobs of other nodes were restarted"
[[ $(submitted failing) == "$jobs" ]] || fail "$(submitted failing) jobs were submitted, not $jobs"
late=$(receipts failing -newer "$folder/killed" ! -name 'tile_*' ! -name report.json)
[[ $late == 0 ]] || fail "$late completed jobs were repeated"
echo "done"
