"""A Slurm of four nodes on this machine, for tests: its daemons run in a folder of their own and end with it."""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time

from support import BIN

COMMANDS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "scontrol", "scancel", "squeue", "sinfo")
NODES = ("n1", "n2", "n3", "n4")  # jobs begin on n3, where there is room, else on n4

CONF = """
ClusterName=snow
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthInfo=socket={folder}/munge
CryptoType=crypto/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
TmpFS={folder}/tmp-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
SlurmctldPort={ports[0]}
SlurmdTimeout=5
MessageTimeout=3
TCPTimeout=1
KillWait=3
MinJobAge=3600
ReturnToService=2
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0,sched_min_interval=100000
JobCompType=jobcomp/none
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=8 Weight=10 State=UNKNOWN
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=8 Weight=10 State=UNKNOWN
NodeName=n3 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[3]} CPUs=8 Weight=1 State=UNKNOWN
NodeName=n4 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[4]} CPUs=8 Weight=2 State=UNKNOWN
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP PriorityTier=1 GraceTime=60
PartitionName=urgent Nodes=ALL MaxTime=INFINITE State=UP PriorityTier=9 PreemptMode=OFF
"""


def missing_commands():
    """What of Slurm is not installed here."""
    path = os.environ["PATH"] + ":/usr/sbin:/sbin"
    missing = [name for name in COMMANDS if shutil.which(name, path=path) is None]
    if not any(pathlib.Path("/usr/lib").glob("**/slurm*/mpi_pmix*.so")):
        missing.append("Slurm's plugin for PMIx")
    return missing


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def processes():
    """(process id, command, environment) of everything that may be looked at."""
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            command = (entry / "comm").read_text().strip()
            variables = (entry / "environ").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        yield int(entry.name), command, dict(v.split("=", 1) for v in variables if "=" in v)


class Cluster:
    def __init__(self):
        self.holder = tempfile.TemporaryDirectory(prefix="nl-slurm-")
        self.folder = pathlib.Path(self.holder.name)
        self.daemons = {}
        for name in ("state", *(f"{kind}-{node}" for kind in ("spool", "tmp") for node in NODES)):
            (self.folder / name).mkdir()
        (self.folder / "key").write_bytes(os.urandom(64))
        (self.folder / "key").chmod(0o600)
        os.chmod(self.folder, 0o755)
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        conf = self.folder / "slurm.conf"
        conf.write_text(CONF.format(host=socket.gethostname().split(".")[0], user=user, folder=self.folder, ports=free_ports(5)))
        # Both nodes are this machine, which need not reach itself by all of its addresses.
        # Nor does it know of a job that the tests themselves may be part of. What two starts of a job share on one machine,
        # and not on two, is the memory of their ranks: it would have the same name.
        outside = {name: value for name, value in os.environ.items() if not name.startswith("SLURM_")}
        self.environment = {**outside, "SLURM_CONF": str(conf), "PATH": f"{BIN}:{os.environ['PATH']}:/usr/sbin:/sbin",
                            "OMPI_MCA_btl": "self,tcp", "OMPI_MCA_btl_tcp_if_include": "lo", "OMPI_MCA_oob_tcp_if_include": "lo"}
        try:
            self.start_daemons()
        except BaseException:
            self.close()
            raise

    def start_daemons(self):
        munge = [f"--{name}={self.folder}/{name}" for name in ("pid-file", "log-file", "seed-file")]
        self.start("munged", "munged", "-F", "--force", f"--key-file={self.folder}/key", f"--socket={self.folder}/munge", *munge)
        self.wait(lambda: (self.folder / "munge").exists(), "munged")
        self.start("slurmctld", "slurmctld", "-D")
        for node in NODES:
            self.start(node, "slurmd", "-D", "-N", node)
        self.wait(lambda: self.run("sinfo", "-h", "-t", "idle", "-o", "%D", check=False).strip() == str(len(NODES)), "idle nodes")

    def start(self, name, *command):
        log = open(self.folder / f"{name}.out", "w")
        self.daemons[name] = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=log,
                                              stderr=subprocess.STDOUT, start_new_session=True)
        log.close()

    def run(self, *command, check=True):
        done = subprocess.run([str(word) for word in command], env=self.environment, capture_output=True, text=True, timeout=60)
        if check and done.returncode != 0:
            raise AssertionError(f"{command}: {done.stderr}")
        return done.stdout

    def wait(self, condition, what, seconds=240, look_again=0.1):
        """Long enough for a machine with much else to do: that something never comes is what it finds."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                logs = "\n".join(f"{p.name}: {p.read_text()[-1500:]}" for p in self.folder.glob("*.log"))
                raise AssertionError(f"waited in vain for {what}\n{logs}")
            time.sleep(look_again)

    def kill_node(self, node):
        """The daemon of a node and what it started for jobs; the jobs' own processes go on, as if it were cut off."""
        self.kill_daemon(node)
        self.kill_steps(node)

    def kill_daemon(self, node):
        daemon = self.daemons.pop(node)
        daemon.kill()
        daemon.wait()

    def kill_steps(self, node):
        """What the daemon of a node started for jobs, and what watches over their processes."""
        steps = [pid for pid, command, _ in processes() if command.startswith("slurmstepd") and self.stepd_node(pid) == node]
        for pid in steps:
            os.kill(pid, signal.SIGKILL)
        return len(steps)

    def stepd_node(self, pid):
        """The node of a slurmstepd, by the log that it has open."""
        links = [os.readlink(link) for link in pathlib.Path(f"/proc/{pid}/fd").iterdir() if link.is_symlink()]
        return next((node for node in NODES if f"{self.folder}/slurmd-{node}.log" in links), None)

    def close(self):
        self.run("scancel", "-f", "-s", "KILL", "--me", check=False)
        for pid, _, variables in processes():
            if variables.get("SLURM_CONF") == self.environment["SLURM_CONF"] and pid != os.getpid():
                if all(pid != daemon.pid for daemon in self.daemons.values()):
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
        for daemon in self.daemons.values():
            daemon.kill()
        for daemon in self.daemons.values():
            daemon.wait()
        self.holder.cleanup()


class Job:
    """A job of a script of slurm/."""

    def __init__(self, cluster, folder, script, *options, **variables):
        self.cluster = cluster
        self.folder = folder
        self.log = folder / f"{variables['OUTPUT']}.log"
        export = ",".join(["ALL"] + [f"{name}={value}" for name, value in variables.items()])
        words = ["sbatch", "--parsable", "-D", folder, "-o", self.log, "-c", "1", "-t", "10", *options, f"--export={export}", script]
        self.id = cluster.run(*words).strip()

    def state(self):
        """Of an array: of all its tasks, where they have the same."""
        states = set(self.cluster.run("squeue", "-h", "-t", "all", "-j", self.id, "-o", "%T").split())
        return states.pop() if len(states) == 1 else "RUNNING"

    def said(self):
        return self.log.read_text() if self.log.exists() else ""

    def ranks(self):
        """Process ids by rank."""
        return {int(variables["SLURM_PROCID"] if "PMIX_RANK" not in variables else variables["PMIX_RANK"]): pid
                for pid, command, variables in processes()
                if command == "noiseloom" and variables.get("SLURM_JOB_ID") == self.id
                and variables.get("SLURM_CONF") == self.cluster.environment["SLURM_CONF"]}

    def node_of(self, rank):
        return next(variables["SLURMD_NODENAME"] for pid, _, variables in processes() if pid == rank)

    def hold(self, output):
        """Suspends all ranks as soon as something is saved; their process ids."""
        self.cluster.wait((self.folder / output).exists, f"{output}; {self.said()}", look_again=0.02)
        ranks = self.ranks()
        self.send(ranks, signal.SIGSTOP)
        if not ranks or "stopped by" in self.said():
            raise AssertionError(f"the run was over before it could be held: it needs more iterations\n{self.said()}")
        return ranks

    def send(self, ranks, number):
        for pid in ranks.values():
            os.kill(pid, number)

    def restarts(self):
        return int(re.search(r"Restarts=(\d+) ", self.cluster.run("scontrol", "show", "job", self.id))[1])

    def wait_for_requeue(self):
        """Slurm lets a job that is queued again wait for two minutes; here for two seconds."""
        self.cluster.wait(lambda: self.restarts() > 0 and self.state() != "COMPLETING", f"the requeue of {self.id}")
        if self.state() == "PENDING":
            self.cluster.run("scontrol", "update", f"JobId={self.id}", "StartTime=now+2")

    def wait_for_requeue_or_end(self):
        self.cluster.wait(lambda: self.restarts() > 0 or self.state() == "COMPLETED", f"the requeue or the end of {self.id}: {self.said()}")
        if self.restarts() > 0:
            self.wait_for_requeue()

    def wait_for_end(self):
        self.cluster.wait(lambda: self.state() not in ("PENDING", "RUNNING", "COMPLETING"), f"the end of {self.id}: {self.said()}")
        return self.state()
