#!/usr/bin/env python3
"""Runs one job of a workflow and writes its receipt:

    job.py RECEIPT PRODUCT -- PROGRAM [ARGUMENT...]

PRODUCT: output file of the program, if any; it is deleted first. If the program ends with exit code 0,
1 or 2, the receipt contains exit code, wall time, CPU time, peak memory and error. Then the job is done,
even if it failed, and other jobs continue. If a signal ends the program, or if it cannot be started, there
is no receipt: job.py fails, and the job must be repeated. The output of the program is written to RECEIPT
with the ending .log.
"""
import fcntl
import json
import os
import resource
import signal
import subprocess
import sys
import time


def last_error(log):
    """The last error in the log; without an error, the last line."""
    with open(log, encoding="utf-8", errors="replace") as file:
        lines = [line.strip() for line in file if line.strip()]
    errors = [line for line in lines if line.startswith("error: ")]
    return (errors or lines or [""])[-1]


def main():
    receipt, product, separator, *command = sys.argv[1:]
    if separator != "--" or not command:
        sys.exit(__doc__)
    stem = os.path.splitext(receipt)[0]
    for path in (os.path.dirname(receipt), os.path.dirname(product)):
        os.makedirs(path or ".", exist_ok=True)
    # The program holds the lock until it ends, even if job.py ends before. A repeated job waits for
    # it.
    lock = os.open(stem + ".lock", os.O_RDWR | os.O_CREAT, 0o666)
    fcntl.flock(lock, fcntl.LOCK_EX)
    if os.path.exists(product):
        os.remove(product)
    begin = time.monotonic()
    with open(stem + ".log", "wb") as log:
        # A separate process group: an interrupted scan has to kill the program. With SIGINT, the
        # program would write partial results.
        program = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log,
                                   stderr=subprocess.STDOUT, pass_fds=[lock], start_new_session=True)
        for ending in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(ending, lambda *_: sys.exit(f"error: {stem} was interrupted"))
        try:
            code = program.wait()
        finally:
            program.kill()
    if code not in (0, 1, 2):
        sys.exit(f"error: {command[0]} ended by {'signal' if code < 0 else 'exit code'} {abs(code)}; "
                 f"see {stem}.log")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    outcome = {
        "job": os.path.basename(stem),
        "exit": code,
        "seconds": round(time.monotonic() - begin, 3),
        "cpu_seconds": round(used.ru_utime + used.ru_stime, 3),
        "peak_mb": round(used.ru_maxrss / 1024, 1),
        "error": last_error(stem + ".log") if code else "",
        "product": product,
    }
    with open(receipt + ".partial", "w", encoding="utf-8") as file:
        json.dump(outcome, file)
        file.flush()
        os.fsync(file.fileno())
    os.replace(receipt + ".partial", receipt)


if __name__ == "__main__":
    main()
