# The runs of a batch (surfit_batch), in its folder, which holds batch.json. Each leaves a receipt in
# jobs/ (job.py): it is done where there is one, failed or not. config: tools, the folder of the
# programs.
import json
from pathlib import Path
from shlex import quote

with open("batch.json", encoding="utf-8") as file:
    batch = json.load(file)
# A cluster writes its logs there before a job could make it.
Path("jobs").mkdir(exist_ok=True)


def receipts(_):
    return [f"jobs/run_{name}.json" for name in batch["runs"]]


def literal(path):
    """A path in a shell command, whose braces are Snakemake's."""
    return quote(str(path)).replace("{", "{{").replace("}", "}}")


rule all:
    input: receipts

rule run:
    input: "flags/{name}.flags"
    output: "jobs/run_{name}.json"
    threads: batch["threads"]
    resources: mem_mb=batch["memory_mb"], minutes=batch["minutes"]
    shell:
        f"python3 {literal(Path(workflow.basedir) / 'job.py')} {{output:q}} "
        f"runs/{{wildcards.name:q}}/summary.json -- {literal(Path(config['tools']) / 'surfit_slam')} "
        "--flagfile={input:q} --output=runs/{wildcards.name:q}"
