#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""A plan worked on by three nodes of Slurm on this machine, whatever happens to them: slurm.py STEREOGRID

Sixty shards of built-in scenes, and of recorded drives where STEREOGRID_DATA names their folder. A node is killed with
everything on it, the controller is killed and started again, a shard crashes, one is out of memory, one input is
poison. What is merged equals, byte for byte, what one process makes. Prints how long each recovery took, as a table.

Root only: Slurm's own programs are started here on the loopback, with a key and a state of their own, and installed
with apt-get where they are not. Exit status 77: that cannot be done here.
"""
import filecmp
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TOOL = Path(sys.argv[1]).resolve()  # in main(): a copy, which nobody builds anew meanwhile
NODES = ("n1", "n2", "n3")
PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "munged")
CRASHING, STARVED = 5, 11  # shards


def skip(why: str):
    print(f"SKIPPED: {why}")
    sys.exit(77)


def require_slurm():
    if os.geteuid() != 0:
        skip("Slurm's nodes need root")
    if all(map(shutil.which, PROGRAMS)):
        return
    if not shutil.which("apt-get"):
        skip("Slurm is not installed, and there is no apt-get")
    # its own services are of no use here
    install = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", "slurm-wlm", "munge"]
    done = subprocess.run(install, env=os.environ | {"DEBIAN_FRONTEND": "noninteractive"}, capture_output=True, check=False)
    if done.returncode != 0 or not all(map(shutil.which, PROGRAMS)):
        skip("Slurm cannot be installed")


def free_ports(count: int) -> list:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    """slurmctld and three slurmd, with their own munged."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.processes = {}
        self.environment = os.environ | {"SLURM_CONF": str(folder / "slurm.conf")}
        self.write_configuration()

    def write_configuration(self):
        host = socket.gethostname().split(".")[0]
        controller, *ports = free_ports(4)
        nodes = "\n".join(f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=1500"
                          for node, port in zip(NODES, ports))
        (self.folder / "slurm.conf").write_text(f"""ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={self.folder}/munge.socket,cred_expire=5
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/%n
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/%n.pid
SlurmctldLogFile={self.folder}/slurmctld.log
SlurmdLogFile={self.folder}/%n.log
CommunicationParameters=NoInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=1
JobAcctGatherParams=OverMemoryKill
SchedulerParameters=bf_interval=2,sched_min_interval=500000,batch_sched_delay=1
SlurmdTimeout=10
SlurmctldTimeout=10
KillWait=5
ReturnToService=2
{nodes}
PartitionName=all Nodes=ALL Default=YES State=UP MaxTime=INFINITE
""", encoding="utf-8")
        for name in ("state", *NODES):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)

    def start(self, name: str):
        if name == "munged":
            command = ["munged", "--foreground", "--force", "--num-threads=2", f"--key-file={self.folder}/munge.key",
                       f"--socket={self.folder}/munge.socket", f"--pid-file={self.folder}/munge.pid",
                       f"--log-file={self.folder}/munge.log", f"--seed-file={self.folder}/munge.seed"]
        elif name == "slurmctld":
            command = ["slurmctld", "-D"]
        else:
            command = ["slurmd", "-D", "-N", name]
        with open(self.folder / f"{name}.out", "ab") as out:
            self.processes[name] = subprocess.Popen(command, env=self.environment, stdout=out, stderr=out)

    def start_all(self):
        self.start("munged")
        wait_for(lambda: (self.folder / "munge.socket").exists(), 20, "munged")
        for name in ("slurmctld", *NODES):
            self.start(name)
        wait_for(lambda: self.idle_nodes() == len(NODES), 60, "the nodes")

    def kill(self, name: str):
        """With all that has come from it."""
        victims = [self.processes[name].pid] + descendants(self.processes[name].pid)
        if name in NODES:
            victims += [pid for pid in processes_with(f"SLURMD_NODENAME={name}")]
            victims += [pid for pid in step_daemons(self.folder / name)]
        for pid in victims:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.processes[name].wait()

    def call(self, *words) -> str:
        done = subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False)
        return done.stdout if done.returncode == 0 else ""

    def idle_nodes(self) -> int:
        return self.call("sinfo", "-h", "-N", "-o", "%t").split().count("idle")

    def tasks_on(self, node: str) -> list:
        return [int(task) for task in self.call("squeue", "-h", "-r", "-t", "R", "-w", node, "-o", "%K").split()]

    def resume_drained(self):
        """A controller that was killed knows less than its nodes, which it then drains until somebody has looked."""
        for line in self.call("sinfo", "-h", "-N", "-o", "%N %t").splitlines():
            node, state = line.split()
            if state.startswith(("drain", "drng", "down")) and self.processes[node].poll() is None:
                self.call("scontrol", "update", f"nodename={node}", "state=resume")

    def queued(self) -> int:
        return len(self.call("squeue", "-h", "-r", "-o", "%i").split())

    def stop(self):
        self.call("scancel", "--full", "-u", "root")
        for name in (*NODES, "slurmctld", "munged"):
            if name in self.processes and self.processes[name].poll() is None:
                self.kill(name)


def descendants(pid: int) -> list:
    children = Path(f"/proc/{pid}/task/{pid}/children")
    try:
        found = [int(child) for child in children.read_text(encoding="utf-8").split()]
    except OSError:
        return []
    return found + [deeper for child in found for deeper in descendants(child)]


def processes_with(setting: str) -> list:
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if setting.encode() in (entry / "environ").read_bytes().split(b"\0"):
                    found.append(int(entry.name))
            except OSError:
                pass
    return found


def step_daemons(spool: Path) -> list:
    """slurmstepd of a node: they hold their node's spool folder open or work in it, and have no environment of it."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            if (entry / "comm").read_text(encoding="utf-8").strip() != "slurmstepd":
                continue
            files = [os.readlink(fd) for fd in (entry / "fd").iterdir()] + [os.readlink(entry / "cwd")]
        except OSError:
            continue
        if any(name.startswith(str(spool)) for name in files):
            found.append(int(entry.name))
    return found


def wait_for(condition, seconds: float, what: str) -> float:
    start = time.monotonic()
    while not condition():
        if time.monotonic() - start > seconds:
            raise AssertionError(f"waited {seconds} s for {what}")
        time.sleep(0.1)
    return time.monotonic() - start


def tool(*words, expect=0) -> str:
    done = subprocess.run([TOOL, "batch", *map(str, words)], capture_output=True, text=True, check=False)
    assert expect is None or done.returncode == expect, f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def status(plan: Path) -> dict:
    return json.loads(tool("status", plan, "--json"))


def make_plan(folder: Path) -> Path:
    """Sixty shards, the last of which is poison."""
    bad = folder / "bad"
    subprocess.run([TOOL, "-q", "simulate", "street?frames=4&width=320&height=200", "--out", bad], check=True)
    recorded = sorted(Path(os.environ["STEREOGRID_DATA"]).glob("kitti_*0*")) if "STEREOGRID_DATA" in os.environ else []
    recorded = [path for path in recorded if (path / "calib.txt").exists()]
    print(f"{len(recorded)} recorded drives")
    scenes = [f"scene:street?frames=24&seed={seed}&width=320&height=200" for seed in range(1, 31)]
    plan = folder / "plan"
    tool("plan", *scenes[:len(scenes) - 3 * len(recorded)], *recorded, bad, "--frames-per-shard", 12, "--warm-up", 6,
         "--out", plan)
    for image in (bad / "left").iterdir():
        image.write_bytes(b"x" * image.stat().st_size)
    return plan


def reference_of(plan: Path, folder: Path) -> Path:
    one = folder / "one"
    one.mkdir()
    for file in ("plan.json", "manifest.jsonl", "manifest.index"):
        shutil.copy(plan / file, one / file)
    start = time.monotonic()
    tool("run", one, "--all", "--threads", 0, expect=65)
    print(f"one process: {time.monotonic() - start:.0f} s")
    tool("merge", one, "--out", folder / "one-merged", "--runs", "--allow-missing")
    return folder / "one-merged"


def unlucky_tool(folder: Path) -> Path:
    """The program, but for two shards' first runners: one crashes, one wants all memory."""
    path = folder / "stereogrid"
    path.write_text(f"""#!/bin/sh
case "$SLURM_ARRAY_TASK_ID.${{SLURM_RESTART_COUNT:-0}}" in
  {CRASHING}.0) sh -c 'kill -SEGV $$'; exit $? ;;
  {STARVED}.0) exec python3 -c 'import time; hog = bytearray(3 << 30); hog[::4096] = b"x" * len(hog[::4096]); time.sleep(60)' ;;
esac
exec {TOOL} "$@"
""", encoding="utf-8")
    path.chmod(0o755)
    return path


def done_shards(plan: Path) -> set:
    names = {path.name for path in (plan / "results").glob("*/*")}
    with open(plan / "manifest.jsonl", encoding="utf-8") as lines:
        return {shard["shard"] for shard in map(json.loads, lines) if shard["digest"][:16] in names}


def only_starved_is_left(plan: Path) -> bool:
    now = status(plan)
    return now["to_do"] == str(STARVED) and now["running"] == 0


def disturb(cluster: Cluster, plan: Path) -> list:
    """Kills a node and the controller; (what, seconds until all that they had is done)."""
    rows = []
    wait_for(lambda: len(done_shards(plan)) >= 6 and cluster.tasks_on("n2"), 300, "the first results")
    lost = set(cluster.tasks_on("n2"))
    cluster.kill("n2")
    time.sleep(2)
    cluster.kill("slurmctld")
    begun = status(plan)
    print(f"killed: a node with tasks {sorted(lost)}, and the controller, when {begun['done']} shards were done")
    controller = time.monotonic()
    cluster.start("slurmctld")
    wait_for(cluster.queued, 60, "the controller")
    rows.append(("controller killed, until it answers", time.monotonic() - controller))
    rows.append(("node killed, until its tasks are done elsewhere",
                 2 + wait_for(lambda: cluster.resume_drained() or lost <= done_shards(plan), 400, f"tasks {lost}")))
    cluster.start("n2")
    rows.append(("node started again, until it works", wait_for(lambda: cluster.tasks_on("n2") or not cluster.queued(), 300,
                                                                "the node")))
    return rows


def expect_equal(a: Path, b: Path):
    names = [sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()) for folder in (a, b)]
    assert names[0] == names[1], set(names[0]) ^ set(names[1])
    different = [name for name in names[0] if name != "timing.json" and not filecmp.cmp(a / name, b / name, shallow=False)]
    for name in different[:1]:
        for left, right in zip((a / name).read_text().splitlines(), (b / name).read_text().splitlines()):
            if left != right:
                print(f"{name}:\n{left[:600]}\n{right[:600]}")
    assert not different, different
    print(f"{len(names[0])} merged files are equal")


def work_on(cluster: Cluster, plan: Path, folder: Path):
    shards = status(plan)["shards"]
    reference = reference_of(plan, folder)
    cluster.start_all()
    command = tool("submit", plan, "--engine", "slurm", "--tool", unlucky_tool(folder), "--retries", 8)
    start = time.monotonic()
    subprocess.run(["sh", "-c", command], env=cluster.environment, check=True)
    rows = disturb(cluster, plan)
    # not for the queue: a task that was done when its node died waits there to be started once more
    wait_for(lambda: cluster.resume_drained() or only_starved_is_left(plan), 900, "all tasks")
    cluster.call("scancel", "--full", "-u", "root")
    # Slurm ends a job that takes too much memory as a whole, and does not queue it again: that is for a person to do
    assert status(plan)["to_do"] == str(STARVED), status(plan)
    command = tool("submit", plan, "--engine", "slurm", "--memory-mb", 1000)
    again = time.monotonic()
    subprocess.run(["sh", "-c", command], env=cluster.environment, check=True)
    wait_for(lambda: cluster.resume_drained() or STARVED in done_shards(plan), 200, "the shard that was out of memory")
    rows.append(("out of memory, from the second submit on", time.monotonic() - again))
    rows.append((f"all {shards} shards, with everything that happened", time.monotonic() - start))
    found = status(plan)
    assert found["running"] == 0 and (found["done"], found["failed"]) == (shards - 1, 1), found
    log = "".join(path.read_text(errors="replace") for path in (plan / "submit-slurm" / "logs").iterdir())
    assert "egmentation" in log and "emory" in log, "the logs tell neither of the crash nor of the memory"
    tool("merge", plan, "--out", folder / "merged", "--runs", "--allow-missing")
    expect_equal(folder / "merged", reference)
    print("\n| what | s |\n|---|---|")
    for what, seconds in rows:
        print(f"| {what} | {seconds:.0f} |")


def main():
    global TOOL
    require_slurm()
    with tempfile.TemporaryDirectory(prefix="stereogrid-slurm-") as name:
        folder = Path(name).resolve()
        TOOL = Path(shutil.copy(TOOL, folder / "tool"))
        cluster = Cluster(folder)
        try:
            work_on(cluster, make_plan(folder), folder)
        except BaseException:
            for log in ("slurmctld.log", "slurmctld.out", *(f"{node}.log" for node in NODES)):
                if (folder / log).exists():
                    print(f"--- {log}\n" + "\n".join((folder / log).read_text(errors="replace").splitlines()[-25:]))
            raise
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
