#!/usr/bin/env python3
"""Tells Snakemake what became of a job: running, success or failed. scontrol needs no accounting."""
import re
import subprocess
import sys

shown = subprocess.run(["scontrol", "--oneliner", "show", "job", sys.argv[1]],
                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
state = re.search(r"JobState=(\S+)", shown.stdout)
if state is None:
    # Slurm forgets jobs after a while (MinJobAge), but not at once; or it does not answer just now.
    print("failed" if "Invalid job id" in shown.stdout else "running")
elif state[1] == "COMPLETED":
    print("success")
elif state[1] in ("BOOT_FAIL", "CANCELLED", "DEADLINE", "FAILED", "OUT_OF_MEMORY", "TIMEOUT", "NODE_FAIL"):
    # What a node took down with it is queued again by itself (--requeue).
    print("failed")
else:
    print("running")
