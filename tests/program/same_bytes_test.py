"""The same /samples for any number of ranks, threads and interruptions, and without FMA."""

import os
import signal
import subprocess
import time

from support import PLAIN_CPU, THOROUGH, ProgramTest, main

PRODUCT = """
[texture]
size    = { x = 23, y = 19, t = 11 }
samples = "hemisphere-cosine"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
stop = { iterations = 40 }
"""

SUM = """
[texture]
size    = { x = 16, y = 16, t = 7, z = 3 }
samples = "vector2"
[filter]
combine = "sum"
groups  = [ { axes = "xy", kernel = "gauss-energy", sigma = 1.2 }, { axes = "t", kernel = "gauss-energy", sigma = 1.2 } ]
[energy]
value_kernel = "stbn"
[optimizer]
stop = { iterations = 12 }
"""

DIFFERENCES = PRODUCT.replace('"hemisphere-cosine"', '{ space = "vector2", distance = "manhattan" }')

# Wide enough for tiles.
TILES = """
[texture]
size    = { x = 131, y = 97, t = 2 }
samples = "circle"
[filter]
groups  = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 20 }
"""

VOID_AND_CLUSTER = """
[texture]
size    = { x = 14, y = 9, z = 3, w = 5 }
[filter]
combine = "sum"
groups  = [ { axes = "xy", kernel = "gauss-energy", sigma = 1.2 }, { axes = "zw", kernel = "gauss-energy", sigma = 1.0 } ]
[optimizer]
method   = "void-and-cluster"
bounded  = "w"
bits     = 6
equalize = "slice"
"""

CONSTRUCT = PRODUCT.replace("hemisphere-cosine", "gauss").replace("stop = { iterations = 40 }", 'method = "construct"')

FAST = PRODUCT.replace("[optimizer]", '[optimizer]\nmethod = "fast"').replace("hemisphere-cosine", "gauss")


class SameBytes(ProgramTest):
    def checksum(self, config, *arguments, **options):
        self.run_program("generate", config, "-o", "run.h5", "--overwrite", "--progress", "none", *arguments, **options)
        return self.samples_checksum("run.h5")

    def test_ranks_threads_and_processors(self):
        for name, text in (("product", PRODUCT), ("sum", SUM), ("differences", DIFFERENCES), ("tiles", TILES), ("fast", FAST),
                           ("void and cluster", VOID_AND_CLUSTER), ("construct", CONSTRUCT)):
            with self.subTest(name):
                config = self.write(name.replace(" ", "-") + ".toml", text)
                expected = self.checksum(config, "--threads", 1)
                # The tests of folders have each method on two ranks, three and five; "tiles" has two slices for three ranks.
                divisions = [(3, 2)]
                if THOROUGH or name == "product":
                    divisions = [(1, 2), (2, 1), (3, 2), (5, 1)]
                if THOROUGH:
                    divisions.append((13, 1))
                for ranks, threads in divisions:
                    self.assertEqual(self.checksum(config, "--threads", threads, ranks=ranks), expected, (ranks, threads))
                self.assertEqual(self.checksum(config, environment=PLAIN_CPU), expected, "without FMA")
                self.assertNotEqual(self.checksum(config, "--set", "texture.seed=2"), expected)

    def test_three_interruptions_and_other_ranks(self):
        config = self.write("run.toml", PRODUCT.replace("iterations = 40", "iterations = 150"))
        expected = self.checksum(config)
        stopped = 0
        for ranks, number in ((2, signal.SIGUSR1), (5, signal.SIGUSR2), (1, signal.SIGTERM), (3, signal.SIGINT)):
            command = self.command("generate", config, "-o", "stopped.h5", "--resume", "--progress", "json", ranks=ranks)
            if ranks == 1:
                command = self.command("generate", config, "-o", "stopped.h5", "--resume", "--progress", "json")
            process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=self.folder)
            for line in process.stderr:
                if '"iterations"' in line:
                    break  # under way
            if number in (signal.SIGTERM, signal.SIGINT) and ranks > 1:
                number = signal.SIGUSR1  # mpirun kills its ranks soon after these two
            process.send_signal(number)
            process.stderr.read()
            status = process.wait(timeout=60)
            process.stderr.close()
            self.assertIn(status, (0, 75), (ranks, number))
            stopped += status == 75
        self.assertGreaterEqual(stopped, 3, "the run was too short to be interrupted")
        self.run_program("generate", config, "-o", "stopped.h5", "--resume", "--progress", "none", ranks=2)
        self.assertEqual(self.samples_checksum("stopped.h5"), expected)
        self.assertEqual(self.info("stopped.h5")["provenance"]["parts"], stopped + 1)

    def test_a_time_limit_that_is_always_over_makes_one_step_a_part(self):
        config = self.write("run.toml", PRODUCT.replace("iterations = 40", "iterations = 3"))
        expected = self.checksum(config)
        statuses = []
        while not statuses or statuses[-1] == 75:
            done = self.run_program("generate", config, "-o", "slow.h5", "--resume", "--time-limit", "0.000001s",
                                    "--checkpoint-every", "0.000001s", "--progress", "none", expect=None)
            self.assertIn(done.returncode, (0, 75), done.stderr)
            statuses.append(done.returncode)
            self.assertLess(len(statuses), 100)
        # 11 slices that are coupled need at least four classes, and each class is a step.
        self.assertGreaterEqual(len(statuses), 3 * 4)
        self.assertEqual(self.samples_checksum("slow.h5"), expected)


if __name__ == "__main__":
    main()
