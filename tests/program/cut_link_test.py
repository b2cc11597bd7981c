"""A link between two nodes that is cut, for some seconds and for ever. The nodes are network namespaces of this machine.

As root on Linux alone; part of tools/test --all."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time

from support import BIN, MPIEXEC, THOROUGH, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 17, y = 13, t = 6 }
samples = "tent"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 12000 }
"""
# What mpirun calls to start its daemon on another node: in the namespace, and under the node's name.
AGENT = """#!/bin/sh
shift
exec ip netns exec {node} unshare -u sh -c "hostname {node}; $*"
"""


def run(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def why_impossible():
    if os.getuid() != 0:
        return "only root may make network namespaces"
    missing = [name for name in ("ip", "unshare") if shutil.which(name) is None]
    if missing:
        return f"there is no {', '.join(missing)}"
    version = subprocess.run([MPIEXEC, "--version"], capture_output=True, text=True).stdout
    if "Open MPI" not in version and "OpenRTE" not in version:
        return "mpirun is not Open MPI's"
    try:
        with Link("nl-probe"):
            return ""
    except subprocess.CalledProcessError as error:
        return f"a network namespace cannot be made: {error.stderr.strip()}"


class Link:
    """Two nodes, NAME-a and NAME-b, with 10.99.7.1 and 10.99.7.2."""

    def __init__(self, name):
        self.nodes = [f"{name}-a", f"{name}-b"]
        self.addresses = ["10.99.7.1", "10.99.7.2"]

    def __enter__(self):
        try:
            for node in self.nodes:
                run("ip", "netns", "add", node)
                run("ip", "-n", node, "link", "set", "lo", "up")
            run("ip", "-n", self.nodes[0], "link", "add", "cable", "type", "veth", "peer", "name", "cable", "netns", self.nodes[1])
            for node, address in zip(self.nodes, self.addresses):
                run("ip", "-n", node, "address", "add", f"{address}/24", "dev", "cable")
                run("ip", "-n", node, "link", "set", "cable", "up")
        except subprocess.CalledProcessError:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for node in self.nodes:
            for pid in subprocess.run(["ip", "netns", "pids", node], capture_output=True, text=True).stdout.split():
                with contextlib.suppress(ProcessLookupError):
                    os.kill(int(pid), signal.SIGKILL)
            subprocess.run(["ip", "netns", "delete", node], capture_output=True)

    def set(self, state):
        run("ip", "-n", self.nodes[1], "link", "set", "cable", state)


class CutLink(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("run.toml", CONFIG)
        self.run_program("generate", "run.toml", "-o", "straight.h5", "--quiet")
        self.link = Link(f"nl{os.getpid()}")
        self.link.__enter__()
        self.addCleanup(self.link.__exit__)
        self.write("agent", AGENT.format(node=self.link.nodes[1])).chmod(0o755)
        # Each rank on a node of its own, over the cable alone.
        options = {"plm_rsh_agent": str(self.folder / "agent"), "btl": "tcp,self", "btl_tcp_if_include": "cable", "oob_tcp_if_include": "cable",
                   "plm_rsh_no_tree_spawn": "1"}
        mca = [word for name, value in options.items() for word in ("--mca", name, value)]
        launcher = ["ip", "netns", "exec", self.link.nodes[0], "unshare", "-u", "sh", "-c", f'hostname {self.link.nodes[0]}; exec "$@"', "sh",
                    MPIEXEC, *mca, "--host", ",".join(self.link.addresses), "--map-by", "node", "-n", "2"]
        command = [*launcher, BIN / "noiseloom", "generate", self.folder / "run.toml", "-o", self.folder / "out.h5", "--checkpoint-every", "0.1s",
                   "--watchdog", "8s", "--progress", "plain"]
        self.process = subprocess.Popen([str(word) for word in command], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.process.stderr.close)
        self.addCleanup(self.process.wait)
        self.addCleanup(self.process.kill)
        self.seen = []
        self.wait_for("saved at")

    def wait_for(self, *words):
        for line in self.process.stderr:
            self.seen.append(line)
            if all(word in line for word in words):
                return line
        self.fail("".join(self.seen))

    def has_the_bytes(self):
        self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum("straight.h5"))

    def test_for_five_seconds(self):
        self.link.set("down")
        time.sleep(5)
        self.link.set("up")
        self.seen += self.process.stderr.readlines()
        self.assertEqual(self.process.wait(60), 0, "".join(self.seen))
        self.has_the_bytes()

    def test_for_ever(self):
        self.link.set("down")
        line = self.wait_for("rank", "has not been heard of")
        self.assertIn(self.link.nodes[1], line)
        self.link.__exit__()  # mpirun waits for its daemon
        self.process.wait(60)
        self.run_program("generate", "run.toml", "-o", "out.h5", "--resume", "--quiet")
        self.has_the_bytes()


if __name__ == "__main__":
    if not THOROUGH and len(sys.argv) == 1:
        print("skipped: links that are cut, which tools/test --all tries", file=sys.stderr)
        sys.exit(77)
    if reason := why_impossible():
        print(f"skipped: links that are cut, as {reason}", file=sys.stderr)
        sys.exit(77)
    main()
