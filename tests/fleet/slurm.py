#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A fleet under Snakemake on three nodes of Slurm on this machine, with faults: slurm.py STEREOGRID

A node is killed with everything on it, the controller is killed and started again, a job crashes. The results equal those
of a fleet on this machine that nothing disturbs.

Root only: Slurm's own programs are started here on the loopback, with a key and a state of their own, and installed
with apt-get where they are not. Exit status 77: not possible here.
"""
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

from support import SIZE, TOOL, command_of, configure, expect_equal, finish, require_snakemake, skip

NODES = ("n1", "n2", "n3")
PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "munged")


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
    """Slurm on the loopback of this machine, with a key and a state of its own: slurmctld and three slurmd, with their own munged."""

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

    def jobs_on(self, node: str) -> list:
        return self.call("squeue", "-h", "-t", "R", "-w", node, "-o", "%i").split()

    def resume_drained(self):
        """A killed controller has less state than its nodes and drains them until an administrator resumes them."""
        for line in self.call("sinfo", "-h", "-N", "-o", "%N %t").splitlines():
            node, state = line.split()
            if state.startswith(("drain", "drng", "down")) and self.processes[node].poll() is None:
                self.call("scontrol", "update", f"nodename={node}", "state=resume")

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


def unlucky_tool(folder: Path) -> Path:
    """The program, but the first run of a drive crashes."""
    path = folder / "stereogrid"
    path.write_text(f'#!/bin/sh\ncase "$*" in *seed=5*) mkdir {folder}/crashed 2>/dev/null && kill -SEGV $$ ;; esac\n'
                    f'exec {TOOL} "$@"\n', encoding="utf-8")
    path.chmod(0o755)
    return path


def done(results: Path) -> int:
    return len(list((results / "done").rglob("all")))


def disturb(cluster: Cluster, results: Path, snakemake: subprocess.Popen):
    """Kills a node and the controller while drives are processed."""
    wait_for(lambda: done(results) >= 2 and cluster.jobs_on("n2"), 300, "the first drives")
    cluster.kill("n2")
    time.sleep(2)
    cluster.kill("slurmctld")
    print(f"killed: a node and the controller, when {done(results)} drives were done")
    time.sleep(3)
    cluster.start("slurmctld")
    wait_for(lambda: cluster.resume_drained() or snakemake.poll() is not None, 600, "Snakemake")


def work_on(cluster: Cluster, folder: Path):
    drives = {f"d{seed}": f"scene:street?frames=60&seed={seed}{SIZE}" for seed in range(1, 13)}
    results = folder / "results"
    finish(configure(folder, drives), folder / "reference")
    config = configure(folder, drives, tool=str(unlucky_tool(folder)), memory_mb=300)
    cluster.start_all()
    with open(folder / "snakemake.log", "wb") as log:
        snakemake = subprocess.Popen(command_of(config, results, profile="slurm"), env=cluster.environment, stdout=log, stderr=log)
        disturb(cluster, results, snakemake)
    said = (folder / "snakemake.log").read_text(errors="replace")
    assert snakemake.wait() == 0, said
    assert (folder / "crashed").exists()
    expect_equal(results, folder / "reference")


def main():
    require_snakemake()
    require_slurm()
    with tempfile.TemporaryDirectory(prefix="stereogrid-slurm-") as name:
        folder = Path(name).resolve()
        cluster = Cluster(folder)
        try:
            work_on(cluster, folder)
        except BaseException:
            for log in ("slurmctld.log", "slurmctld.out", "snakemake.log", *(f"{node}.log" for node in NODES)):
                if (folder / log).exists():
                    print(f"--- {log}\n" + "\n".join((folder / log).read_text(errors="replace").splitlines()[-25:]))
            raise
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
