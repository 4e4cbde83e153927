#!/usr/bin/env python3
"""Prints the state of a job for Snakemake: running, success or failed. scontrol works without accounting."""
import re
import subprocess
import sys

shown = subprocess.run(["scontrol", "--oneliner", "show", "job", sys.argv[1]],
                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
state = re.search(r"JobState=(\S+)", shown.stdout)
if state is None:
    # Slurm deletes a job some time after its end (MinJobAge). Other errors are temporary.
    print("failed" if "Invalid job id" in shown.stdout else "running")
elif state[1] == "COMPLETED":
    print("success")
elif state[1] in ("BOOT_FAIL", "CANCELLED", "DEADLINE", "FAILED", "OUT_OF_MEMORY", "TIMEOUT", "NODE_FAIL"):
    # Slurm queues the jobs of a failed node again (--requeue).
    print("failed")
else:
    print("running")
