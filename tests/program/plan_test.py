"""plan: what it says about a run, to people and to programs, and that it costs next to nothing to ask."""

import json
import resource
import subprocess

import numpy

from support import ProgramTest, main

CONFIG = """
[texture]
size    = { x = 16, y = 16, t = 6 }
samples = "hemisphere-cosine"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 2 } ]
[optimizer]
stop = { iterations = 64 }
"""


class Plan(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def plan(self, *arguments, **options):
        return json.loads(self.run_program("plan", self.config, "--json", *arguments, **options).stdout)

    def test_json_has_all_of_it(self):
        plan = self.plan("--ranks", 3, "--threads", 2, "--ranks-per-node", 2)
        self.assertEqual((plan["pixels"], plan["slices"], plan["channels"], plan["ranks"], plan["threads"]),
                         (1536, 6, 3, 3, 2))
        self.assertEqual([rank["slices"] for rank in plan["memory"]["ranks"]], [2, 2, 2])
        self.assertEqual([rank["halo_slices"] for rank in plan["memory"]["ranks"]], [2, 2, 2])
        self.assertEqual(plan["exchange"]["slice_updates_per_sweep"], 6)
        self.assertGreater(plan["exchange"]["bytes_per_sweep"], 0)
        self.assertEqual(plan["footprint"]["reach"], {"x": 2, "y": 2, "t": 1})
        effects = {effect["name"]: effect["on"] for effect in plan["effects"]}
        self.assertEqual((effects["coupled slices"], effects["density"], effects["tiles"]), (True, True, False))
        self.assertEqual([axis["on"] for axis in plan["axes"]], [True] * 3)
        memory = plan["memory"]
        self.assertGreater(memory["node_bytes"], 1.5 * memory["rank_bytes"])
        self.assertLess(memory["node_bytes"], 2.5 * memory["rank_bytes"])
        self.assertEqual(plan["disk"]["bytes_at_a_save"], 3 * plan["disk"]["run_file_bytes"])
        time = plan["time"]
        self.assertLess(time["seconds_low"], time["seconds"])
        self.assertLess(time["seconds"], time["seconds_high"])
        self.assertAlmostEqual(time["seconds"],
                               sum(time[part] for part in ("start", "moves", "scores", "exchange", "saves")))

    def test_negative_taps_are_mentioned_whatever_the_method(self):
        numpy.save(self.folder / "taps.npy", numpy.array([[0, -0.1, 0], [-0.1, 1, 0], [0, 0, 0]]))
        for method in ("construct", "anneal"):
            self.config.write_text(f"""[texture]
size = {{ x = 16, y = 16 }}
[filter]
groups = [ {{ axes = "xy", kernel = "table", file = "taps.npy" }} ]
[optimizer]
method = "{method}"
""")
            effects = {effect["name"]: effect["why"] for effect in self.plan()["effects"]}
            self.assertIn('"taps.npy": 2 of 9 taps are negative', effects["negative taps"])
            self.assertIn("2 of 9 taps are negative", self.run_program("plan", self.config).stdout)
            numpy.save(self.folder / "taps.npy", numpy.ones((3, 3)))
            self.assertNotIn("negative", self.run_program("plan", self.config).stdout)
            numpy.save(self.folder / "taps.npy", numpy.array([[0, -0.1, 0], [-0.1, 1, 0], [0, 0, 0]]))

    def test_size_of_the_run_file(self):
        self.run_program("generate", self.config, "-o", "run.h5", "--progress", "none")
        planned = self.plan()["disk"]["run_file_bytes"]
        found = (self.folder / "run.h5").stat().st_size
        self.assertGreaterEqual(planned, found)
        self.assertLess(planned, 10 * found)

    def test_size_of_a_run_file_with_what_it_was_made_from(self):
        numpy.save(self.folder / "lists.npy", numpy.random.default_rng(1).random((6, 128 * 128)).astype("f4"))
        size = ("--set", "texture.size={x=128,y=128,t=6}", "--set", 'texture.samples={file="lists.npy"}',
                "--set", "optimizer.stop.iterations=1")
        self.run_program("generate", self.config, "-o", "run.h5", "--progress", "none", *size)
        planned = self.plan(*size)["disk"]["run_file_bytes"]
        found = (self.folder / "run.h5").stat().st_size
        self.assertGreaterEqual(planned, found)
        self.assertLess(planned, 1.5 * found)

    def test_of_a_large_list_the_header_is_read_alone(self):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        cells = 16384 * 16384
        with open(self.folder / "large.npy", "wb") as file:  # a gigabyte of zeros that takes no place
            numpy.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (cells,)})
            file.truncate(file.tell() + 4 * cells)
        large = ("--set", "texture.size={x=16384,y=16384}", "--set", 'texture.samples={file="large.npy"}',
                 "--set", 'filter.groups=[{axes="xy",kernel="gauss",sigma=1.0}]')
        plan = self.plan(*large, afresh=True)
        self.assertGreater(plan["disk"]["run_file_bytes"], 12 * cells)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.assertLess(after.ru_utime - before.ru_utime, 5)
        self.assertGreater(after.ru_utime, before.ru_utime)  # it was a child of this process
        self.assertLess(after.ru_maxrss, 600 * 1024)
        with open(self.folder / "large.npy", "r+b") as file:
            file.truncate(cells)
        refused = self.run_program("plan", self.config, *large, expect=2)
        self.assertIn("large.npy: shape (268435456,) needs 1073741824 bytes", refused.stderr)

    def test_huge_textures_cost_nothing_to_plan(self):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        sizes = ("{x=65536,y=65535}", "{x=32768,y=32768,t=1024}", "{x=64,y=64,t=1000000}")
        for size in sizes:
            groups = '{axes="xy",kernel="gauss",sigma=1.0}'
            if "t=" in size:
                groups += ',{axes="t",kernel="ema",alpha=0.1,rejection=0.1}'
            plan = self.plan("--set", f"texture.size={size}", "--set", f"filter.groups=[{groups}]", "--ranks", 64, afresh=True)
            self.assertGreater(plan["memory"]["node_bytes"], 16 * plan["pixels"])
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        # A second each on a machine that is not too slow or busy; processor time, with room.
        self.assertLess(after.ru_utime - before.ru_utime, 5 * len(sizes))
        self.assertGreater(after.ru_utime, before.ru_utime)
        self.assertLess(after.ru_maxrss, 600 * 1024)

    def test_other_stop_rules_say_what_the_time_is_for(self):
        text = self.run_program("plan", self.config, "--set", 'optimizer.stop={score=0.1}').stdout
        self.assertRegex(text, r"time +until stop\.score is reached; 1000 iterations take about")
        text = self.run_program("plan", self.config, "--set", 'optimizer.stop={time="30s"}').stdout
        self.assertRegex(text, r"time +as long as stop\.time says")

    def test_faults(self):
        for arguments, words in (
            (("--ranks", 0, "--threads", -2), ("--ranks 0: must be at least 1", "--threads -2: must be at least 1")),
            (("--ranks", "many"), ("--ranks",)),
        ):
            refused = self.run_program("plan", self.config, *arguments, expect=2)
            for word in words:
                self.assertIn(word, refused.stderr)
        refused = self.run_program("plan", self.config, "--set", 'texture.samples={file="none.npy"}', expect=2)
        self.assertIn("none.npy", refused.stderr)

    def test_a_plan_that_cannot_be_printed_is_no_success(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run(self.command("plan", self.config), stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 1, done.stderr)


if __name__ == "__main__":
    main()
