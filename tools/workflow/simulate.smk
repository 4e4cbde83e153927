# Simulation in parts: surfit_simulate renders each part in a job, and joins the parts in sequence/.
# Keys of config: flags of surfit_simulate; parts, the number of parts; tools, the folder of the
# programs, if it is not in PATH.
from pathlib import Path
from shlex import quote

PARTS = int(config["parts"])
PROGRAM = quote(str(Path(config["tools"]) / "surfit_simulate")) if "tools" in config else "surfit_simulate"
COMMAND = f"{PROGRAM} {config['flags']} --output=sequence".replace("{", "{{").replace("}", "}}")
# A cluster writes its logs there, before a job can create the folder.
Path("jobs").mkdir(exist_ok=True)


rule all:
    input: "sequence/surface.ply"

rule part:
    output: "sequence.{part,[0-9]+}/surface.ply"
    resources: mem_mb=1000, minutes=600
    shell: COMMAND + " --part={wildcards.part}/" + str(PARTS) + " --threads=1"

# Joining deletes the parts.
rule join:
    input: [f"sequence.{part}/surface.ply" for part in range(1, PARTS + 1)]
    output: "sequence/surface.ply"
    resources: mem_mb=1000, minutes=60
    shell: COMMAND + " --part=join/" + str(PARTS) + " --threads=1"
