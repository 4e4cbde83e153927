# Runs of a batch (surfit_batch). They run in the folder of the batch, which contains batch.json.
# Each run writes a receipt to jobs/ (job.py). A run with a receipt is done, even if it failed.
# Key of config: tools, the folder of the programs.
import json
from pathlib import Path
from shlex import quote

with open("batch.json", encoding="utf-8") as file:
    batch = json.load(file)
# A cluster writes its logs there, before a job can create the folder.
Path("jobs").mkdir(exist_ok=True)


def receipts(_):
    return [f"jobs/run_{name}.json" for name in batch["runs"]]


def literal(path):
    """A path in a shell command. Braces are for Snakemake."""
    return quote(str(path)).replace("{", "{{").replace("}", "}}")


rule all:
    input: receipts

rule run:
    input: "flags/{name}.flags"
    output: "jobs/run_{name}.json"
    threads: batch["threads"]
    resources: mem_mb=4000, minutes=600
    shell:
        f"python3 {literal(Path(workflow.basedir) / 'job.py')} {{output:q}} "
        f"runs/{{wildcards.name:q}}/summary.json -- {literal(Path(config['tools']) / 'surfit_slam')} "
        "--flagfile={input:q} --output=runs/{wildcards.name:q}"
