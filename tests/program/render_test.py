"""render: scenes from file to table, what is off, what is kept, and how expectations end."""

import csv
import json
import re
import subprocess

import numpy
import PIL.Image
import support

SCENE = """
[image]
width = 32
height = 24
frames = 6
repeats = 3
outputs = [%s]
[[noise]]
kind = "white"
[[noise]]
kind = "blue-2d"
size = 16
slices = 4
[effects.%s]
[filter.time]
kernels = ["ema"]
[[filter.space]]
kernel = "gauss"
sigma = 1.0
"""
ORDER = '[[expect]]\norder = "%s"\nspace = "gauss1"\n'


class RenderTest(support.ProgramTest):
    def scene(self, tail="", outputs='"curves"', effect="integrand"):
        return self.write("scene.toml", SCENE % (outputs, effect) + tail)

    def rows(self, name="out/results.csv"):
        with open(self.folder / name) as file:
            return list(csv.DictReader(file))

    def test_a_scene_gives_its_table_and_its_plan(self):
        done = self.run_program("render", self.scene(), "-o", "out")
        self.assertIn("root of the mean squared error in frame 6", done.stdout)
        self.assertEqual(len(self.rows()), 2 * 4)
        self.assertEqual(len(self.rows("out/curves.csv")), 2 * 4 * 6)
        page = (self.folder / "out/report.html").read_text()
        self.assertRegex(page, r"integrand, after ema \+ gauss1: blue-2d has the least error.*times fewer samples than white")
        self.assertIn("<svg", page)
        self.assertNotIn("http", page.replace("http://www.w3.org/", ""))
        plan = json.loads((self.folder / "out/plan.json").read_text())
        for one in plan["passes"]:
            self.assertEqual(one["predicted"], one["counted"], one["name"])
            self.assertEqual(one["calls"]["predicted"], one["calls"]["counted"], one["name"])
            if not one["on"]:
                self.assertEqual(set(one["counted"].values()), {0}, one["name"])
        self.assertEqual([one["name"] for one in plan["passes"] if not one["on"]],
                         ["picture", "density", "light", "columns", "flights", "mesh", "mesh shares", "primary hits", "edge weights",
                          "kernel", "importance", "sky light", "sky truths", "predictions", "carrying", "moving hits", "seeds", "dither",
                          "transparency", "free-flight", "ray-march", "ambient-occlusion", "soft-shadow", "sky",
                          "convolution", "sparse", "histories", "samples so far", "spectra", "pictures"])
        self.assertFalse((self.folder / "out/pictures").exists())

    def test_plan_alone_renders_and_makes_nothing(self):
        scene = self.scene()
        done = self.run_program("render", scene, "--plan")
        self.assertRegex(done.stdout, r"(?m)^integrand +on ")
        self.assertRegex(done.stdout, r"(?m)^dither +off .*no effects.dither")
        self.assertRegex(done.stdout, r"(?m)^noises +on +1 +4 KiB ")        # 16 x 16 x 4 floats, though not made yet
        self.assertRegex(done.stdout, r"(?m)^errors +on +36 +1.125 KiB ")   # the curves of 2 x 3 jobs: 4 stages, 6 frames
        self.assertRegex(self.run_program("--help").stdout, r"same\s+command again, generate and accuracy with --resume")
        self.assertEqual([p.name for p in self.folder.iterdir()], ["scene.toml"])

    def test_expectations_decide_the_exit_status(self):
        scene = self.scene(ORDER % "blue-2d < white")
        self.assertIn("holds", self.run_program("render", scene, "-o", "a").stdout)
        done = self.run_program("render", self.scene(ORDER % "white < blue-2d"), "-o", "b", "--noises", "a/noise", expect=3)
        self.assertRegex(done.stdout, r"fails +white < blue-2d \(integrand, gauss1, frame 6\)")
        done = self.run_program("render", self.scene(ORDER % "white < white"), "-o", "c", "--noises", "a/noise", expect=3)
        self.assertIn("undecided", done.stdout)
        self.assertFalse((self.folder / "b/noise").exists())

    def test_textures_are_made_once(self):
        scene = self.scene()
        self.run_program("render", scene, "-o", "out")
        made = list((self.folder / "out/noise").glob("*.h5"))
        self.assertEqual(len(made), 1)
        before = made[0].stat().st_mtime_ns
        self.run_program("render", scene, "-o", "out", "--overwrite")
        self.assertEqual(made[0].stat().st_mtime_ns, before)
        self.run_program("render", scene, "-o", "out", "--overwrite", "--set", "noise[1].seed=2")
        self.assertEqual(len(list((self.folder / "out/noise").glob("*.h5"))), 2)

    def test_two_commands_share_the_folder_of_textures(self):
        scene = self.scene('[[noise]]\nkind = "sobol-blue"\npoints = 2\n')
        command = ["render", scene, "--noises", "shared", "--threads", "1", "--set", "noise[1].size=64"]
        others = [subprocess.Popen(self.command(*command, "-o", name), cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True) for name in ("one", "two", "three")]
        for other in others:
            said = other.communicate(timeout=120)[1]
            self.assertEqual(other.returncode, 0, said)
        made = sorted(p.name for p in (self.folder / "shared").iterdir())
        self.assertEqual([p.split(".", 1)[1] for p in made], ["h5", "toml", "h"], made)
        for name in ("two", "three"):
            self.assertEqual((self.folder / name / "curves.csv").read_bytes(), (self.folder / "one/curves.csv").read_bytes())

    def test_a_texture_that_was_damaged_is_made_anew_and_that_is_said(self):
        scene = self.scene()
        self.run_program("render", scene, "-o", "out")
        results = (self.folder / "out/results.csv").read_bytes()
        kept = next((self.folder / "out/noise").glob("*.h5"))
        whole = kept.read_bytes()
        for damaged in (whole[:len(whole) // 2], whole[:3000] + bytes(2000) + whole[5000:], b""):
            kept.write_bytes(damaged)
            done = self.run_program("render", scene, "-o", "out", "--overwrite")
            self.assertRegex(done.stderr, r"note: noise \"blue-2d\": .*was damaged and is made anew")
            self.assertEqual((self.folder / "out/results.csv").read_bytes(), results)
        self.assertNotIn("damaged", self.run_program("render", scene, "-o", "out", "--overwrite").stderr)

    def test_keys_are_made_once_and_anew_where_they_were_damaged(self):
        scene = self.write("keys.toml", '[image]\nwidth = 16\nheight = 16\nframes = 2\n[[noise]]\nkind = "sobol-blue"\npoints = 2\n'
                           '[effects.integrand]\n')
        self.run_program("render", scene, "-o", "out")
        kept = self.folder / "out/noise/sobol-blue-2-2-1-1.h"
        text, made = kept.read_bytes(), kept.stat().st_mtime_ns
        self.run_program("render", scene, "-o", "out", "--overwrite")
        self.assertEqual(kept.stat().st_mtime_ns, made)
        kept.write_bytes(text[:-200])
        self.assertIn("was damaged and is made anew", self.run_program("render", scene, "-o", "out", "--overwrite").stderr)
        self.assertEqual(kept.read_bytes(), text)

    def test_kernels_and_maps_of_images_are_read_and_wrong_ones_refused(self):
        numpy.save(self.folder / "kernel.npy", numpy.array([[0, 1, 0], [2, 4, 0]], dtype="float32"))
        numpy.save(self.folder / "black.npy", numpy.zeros((4, 4), dtype="float32"))
        numpy.save(self.folder / "wide.npy", numpy.ones((2, 300), dtype="float32"))
        numpy.save(self.folder / "negative.npy", numpy.array([[1, -1]], dtype="float32"))
        base = "\n[effects.convolution]\nkernel = \"image\"\nfile = \"%s.npy\"\n"
        sparse = "\n[effects.sparse]\nimportance = \"image\"\nfile = \"%s.npy\"\n"
        self.run_program("render", self.scene(base % "kernel" + sparse % "kernel"), "-o", "out")
        errors = {(row["effect"], row["noise"]): float(row["rmse"]) for row in self.rows() if row["space"] == "none"}
        self.assertGreater(errors["convolution", "white"], 0)
        for name, words in (("black", "is black"), ("wide", "at most 255"), ("negative", "holds -1"), ("none", "none.npy")):
            done = self.run_program("render", self.scene(base % name), "-o", "not", expect=2)
            self.assertIn(words, done.stderr)
        self.assertIn("holds -1", self.run_program("render", self.scene(sparse % "negative"), "-o", "not", expect=2).stderr)

    def test_volumes_of_openvdb_are_read_and_wrong_ones_refused(self):
        try:
            import pyopenvdb
        except ImportError:
            self.skipTest("no pyopenvdb (python3-openvdb), which writes the files of this test")

        def save(name, values, grid="density", first=(0, 0, 0), further=()):
            made = pyopenvdb.FloatGrid()
            made.copyFromArray(values, ijk=first)
            for place, value in further:
                made.getAccessor().setValueOn(place, value)
            made.name = grid
            pyopenvdb.write(str(self.folder / (name + ".vdb")), grids=[made])

        upper = numpy.zeros((10, 20, 14), dtype="float32")  # x, y, z, of which y points upward
        upper[:, 10:, :] = 1
        upper[:, 0, :] = 1e-6
        save("upper", upper)
        save("moved", 7 * upper, first=(-13, 40, -2))
        save("other", upper, grid="heat")
        save("nan", upper, further=[((3, 4, 5), float("nan"))])
        save("negative", upper, further=[((3, 4, 5), -1.0)])
        save("zero", 0 * upper)
        save("black", 0 * upper, further=[((3, 4, 5), 0.0)])
        save("one", 0 * upper, further=[((3, 4, 5), 2.0)])
        (self.folder / "words.vdb").write_text("no volume")
        tail = '\n[volume]\ndensity = "file"\nfile = "%s.vdb"\nresolution = 16\nalbedo = 0\n'
        for name in ("upper", "moved"):
            self.run_program("render", self.scene(tail % name, '"images"', "free-flight"), "-o", name)
        for file in ("results.csv", "pictures/free-flight_truth.png"):
            self.assertEqual((self.folder / "moved" / file).read_bytes(), (self.folder / "upper" / file).read_bytes())
        truth = numpy.asarray(PIL.Image.open(self.folder / "upper/pictures/free-flight_truth.png").convert("L"), dtype=float)
        self.assertLess(truth[6, 16], 20)                       # black behind its density
        self.assertGreater(truth[18, 16], 100)                  # the light behind it
        self.assertGreater(truth[6, 2], 100)                    # beside the box
        self.run_program("render", self.scene(tail % "one", effect="free-flight"), "-o", "one")
        for name, words in (("other", 'it has "heat"'), ("nan", "holds nan at voxel"), ("negative", "holds -1 at voxel"),
                            ("zero", "zero.vdb"), ("black", "is 0 everywhere"),
                            ("words", "cannot be read as OpenVDB")):
            done = self.run_program("render", self.scene(tail % name, effect="free-flight"), "-o", "not", expect=2)
            self.assertIn(words, done.stderr)
            self.assertIn(name + ".vdb", done.stderr)
        self.assertFalse((self.folder / "not/results.csv").exists())

    def test_the_same_bytes_on_any_number_of_threads_and_without_vectors(self):
        others = "".join(f"[effects.{name}]\n" for name in ("integrand", "transparency", "free-flight", "ray-march", "ambient-occlusion",
                                                           "soft-shadow", "sky", "convolution", "sparse"))
        scene = self.scene(others + '[volume]\nresolution = 16\n[[filter.space]]\nkernel = "a-trous"\nlevels = 2\n'
                           'edges = ["depth", "normal"]\n', outputs='"curves", "images", "predictions", "spectra"', effect="dither")
        self.run_program("render", scene, "-o", "out", "--threads", "1")
        names = sorted(p.relative_to(self.folder / "out") for p in (self.folder / "out").rglob("*")
                       if p.suffix in (".csv", ".png"))
        self.assertGreater(len(names), 10)
        for folder, options, environment in (("more", ["--threads", "5"], None), ("plain", [], support.PLAIN_CPU)):
            self.run_program("render", scene, "-o", folder, "--noises", "out/noise", *options, environment=environment)
            for name in names:
                self.assertEqual((self.folder / folder / name).read_bytes(), (self.folder / "out" / name).read_bytes(), name)

    def test_what_is_there_is_not_replaced_unasked(self):
        scene = self.scene()
        self.run_program("render", scene, "-o", "out")
        before = (self.folder / "out/results.csv").read_bytes()
        self.assertIn("results.csv", self.run_program("render", scene, "-o", "out", expect=2).stderr)
        self.assertEqual((self.folder / "out/results.csv").read_bytes(), before)

    def test_bad_scenes_start_nothing(self):
        scene = self.scene(ORDER % "blue < white" + "[effect]\n")
        done = self.run_program("render", scene, "-o", "out", expect=2)
        self.assertIn('did you mean "blue-2d"', done.stderr)
        self.assertIn("effects", done.stderr)
        self.assertFalse((self.folder / "out").exists())
        self.run_program("render", "none.toml", "-o", "out", expect=2)
        self.run_program("render", "-o", "out", expect=2)
        self.assertIn("expect[].order", self.run_program("render", "--help-scene").stdout)

    def test_images_of_anybody_are_a_noise(self):
        self.run_program("generate", self.write("c.toml", """
[texture]
size = { x = 16, y = 16, t = 4 }
samples = "vector2"
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 2 }
"""), "-o", "r.h5")
        self.run_program("export", "r.h5", "-o", "images")
        first = sorted((self.folder / "images").glob("*.png"))[0].name
        tail = ""
        for name, file in (("ours", re.sub(r"\d+(?=\.png)", "{}", first)), ("one", first), ("all", "")):
            self.assertTrue(name != "ours" or "{}" in file)
            tail += f'[[noise]]\nname = "{name}"\nkind = "file"\nfile = "images/{file}"\nsamples = "vector2"\n'
        tail += '[[noise]]\nname = "run"\nkind = "file"\nfile = "r.h5"\n'
        self.run_program("render", self.scene(tail), "-o", "out", "--set", "effects.integrand.function=circle")
        errors = {row["noise"]: float(row["rmse"]) for row in self.rows() if row["space"] == "none"}
        for name in ("ours", "one", "all"):
            self.assertAlmostEqual(errors[name], errors["run"], delta=0.03 * errors["run"])
        missing = '[[noise]]\nname = "ours"\nkind = "file"\nfile = "none_{}.png"\nsamples = "vector2"\n'
        done = self.run_program("render", self.scene(missing), "-o", "none", expect=2)
        self.assertIn("none_{}.png", done.stderr)

    def test_a_texture_is_made_anew_when_what_its_config_reads_has_changed(self):
        config = self.write("k.toml", """
[texture]
size = { x = 8, y = 8 }
samples = "uniform"
[filter]
groups = [ { axes = "xy", kernel = "table", file = "taps.npy" } ]
""")
        tail = f'[[noise]]\nname = "ours"\nkind = "config"\nfile = "{config}"\n'
        textures = []
        for taps in ([1, 2, 1], [1, 1, 1, 1, 1]):
            numpy.save(self.folder / "taps.npy", numpy.array(taps, dtype=float))
            self.run_program("render", self.scene(tail), "-o", "out", "--overwrite")
            textures.append(len(list((self.folder / "out/noise").glob("ours-*.h5"))))
        self.assertEqual(textures, [1, 2])


if __name__ == "__main__":
    support.main()
