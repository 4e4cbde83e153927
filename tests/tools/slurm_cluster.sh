#!/usr/bin/env bash
# A Slurm cluster with two nodes on this machine. It uses only the loopback interface, and one folder for
# all files. Functions for tests that run as root:
#   start_cluster FOLDER   with munged, slurmctld and a slurmd for each node; sets SLURM_CONF
#   node_jobs NODE         running jobs of a node: number and name, one job per line
#   restarted_jobs         restarted jobs in the same format
#   fail_node NODE         sets a node to DOWN like an administrator
#   resume_node NODE       returns a node to service
#   kill_node NODE         kills slurmd and the jobs of a node, like a power failure
#   stop_cluster
# All processes end with the test.

slurm_programs=(munged slurmctld slurmd sbatch scancel scontrol)
nodes=(node1 node2)
declare -A daemons=()  # process by name

start_daemon() {  # start_daemon NAME COMMAND...
  setpriv --pdeathsig KILL "${@:2}" >"$cluster/$1.out" 2>&1 &
  daemons[$1]=$!
}

free_ports() {  # free_ports COUNT
  python3 - "$1" <<'P'
import socket, sys
sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(int(sys.argv[1]))]
print(*[each.getsockname()[1] for each in sockets])
P
}

write_cluster_files() {
  local host ports i
  host=$(hostname -s)
  read -r -a ports < <(free_ports $((1 + ${#nodes[@]})))
  head -c 1024 /dev/urandom >"$cluster/munge.key"
  chmod 400 "$cluster/munge.key"
  cat >"$cluster/slurm.conf" <<C
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=${ports[0]}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser=root
AuthType=auth/munge
# Slurm restarts a job after the credential of its former start expires. The default is two minutes.
AuthInfo=socket=$cluster/munge.socket,cred_expire=20
StateSaveLocation=$cluster/state
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmctldLogFile=$cluster/slurmctld.log
SlurmdSpoolDir=$cluster/spool_%n
SlurmdPidFile=$cluster/%n.pid
SlurmdLogFile=$cluster/%n.log
# Nodes have the configured cores and memory, independent of the machine.
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=batch_sched_delay=1
# Keeps records of completed jobs until the end of the test.
MinJobAge=7200
# A node is DOWN after this time without an answer, s.
SlurmdTimeout=10
C
  for ((i = 0; i < ${#nodes[@]}; ++i)); do
    echo "NodeName=${nodes[i]} NodeHostname=$host NodeAddr=127.0.0.1 Port=${ports[i + 1]} CPUs=2 RealMemory=4000"
  done >>"$cluster/slurm.conf"
  echo "PartitionName=all Nodes=ALL Default=YES State=UP" >>"$cluster/slurm.conf"
}

start_cluster() {
  cluster=$1
  mkdir -p "$cluster/state"
  chmod 755 "$cluster"
  write_cluster_files
  export SLURM_CONF=$cluster/slurm.conf
  start_daemon munged munged --foreground --force --key-file="$cluster/munge.key" \
    --socket="$cluster/munge.socket" --pid-file="$cluster/munged.pid" \
    --log-file="$cluster/munged.log" --seed-file="$cluster/munged.seed"
  wait_until "munged's socket" test -S "$cluster/munge.socket"
  start_daemon slurmctld slurmctld -D
  local node
  for node in "${nodes[@]}"; do start_daemon "$node" slurmd -D -N "$node"; done
  for node in "${nodes[@]}"; do wait_until "an idle $node" node_is "$node" IDLE; done
}

wait_until() {  # waits for COMMAND for at most ten minutes
  local i
  for ((i = 0; i < 3000; ++i)); do
    if "${@:2}" >/dev/null 2>&1; then return; fi
    sleep 0.2
  done
  fail "never: $1"
}

# The state is a state of Slurm, for example IDLE or DOWN.
node_is() { [[ $(scontrol --oneliner show node "$1") =~ \ State=$2[*+\ ] ]]; }
cluster_jobs() { scontrol --oneliner show job 2>/dev/null || true; }
restarted_jobs() { cluster_jobs | sed -En 's/^JobId=([0-9]+) JobName=(\S+) .* Restarts=[1-9].*/\1 \2/p'; }
node_jobs() {
  cluster_jobs | sed -En "s/^JobId=([0-9]+) JobName=(\S+) .* JobState=RUNNING .* NodeList=$1 .*/\1 \2/p"
}
fail_node() { scontrol update nodename="$1" state=down reason=test; }
resume_node() { scontrol update nodename="$1" state=resume; }

kill_node() {
  kill -KILL "${daemons[$1]}"
  { wait "${daemons[$1]}" || true; } 2>/dev/null  # suppresses the message of bash
  unset "daemons[$1]"
  local process parent jobs=() parents=()
  mapfile -t jobs < <(node_processes "$1")
  for process in "${jobs[@]}"; do
    parent=$(sed -n 's/^PPid:\t//p' "/proc/$process/status" 2>/dev/null) || continue
    [[ $(<"/proc/$parent/comm") != slurmstepd ]] || parents+=("$parent")
  done 2>/dev/null
  # The parents are killed as well, so that they do not report the end of the jobs.
  ((${#jobs[@]} == 0)) || kill -KILL "${parents[@]}" "${jobs[@]}" 2>/dev/null || true
}

# Process ids of the jobs of a node. One grep is much faster than one per process.
node_processes() {
  grep -lzx "SLURMD_NODENAME=$1" /proc/[0-9]*/environ 2>/dev/null |
    xargs -r grep -lzx "SLURM_CONF=$SLURM_CONF" 2>/dev/null | cut -d / -f 3
}

stop_cluster() {
  ((${#daemons[@]})) || return 0
  timeout 20 scancel --user="$(id -un)" 2>/dev/null || true
  local node
  for node in "${nodes[@]}" slurmctld munged; do
    [[ -z ${daemons[$node]:-} ]] || kill "${daemons[$node]}" 2>/dev/null || true
  done
  wait "${daemons[@]}" 2>/dev/null || true
}
