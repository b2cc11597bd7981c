"""Banks: members, the index, going on after kills, several workers on one folder."""

import csv
import fcntl
import json
import os
import signal
import subprocess
import time

try:
    import h5py
    import numpy
except ImportError:
    print("skipped: python3 has no h5py or no numpy")
    raise SystemExit(77)
from support import BIN, ProgramTest, main

BASE = """
[texture]
size    = { x = 16, y = 16, t = 4 }
samples = "uniform"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "gauss", sigma = 1.0 }, { axes = "t", kernel = "box", size = 3 } ]
[optimizer]
method = "anneal"
stop = { iterations = 60 }
"""
SEEDS = 'base = "base.toml"\n[vary]\n"texture.seed" = "1:%d"\n'


class Bank(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("base.toml", BASE)

    def bank(self, *arguments, **options):
        return self.run_program("bank", "bank.toml", "-o", "made", *arguments, **options)

    def index(self, folder="made", after_kill=False):
        """The rows of index.csv; index.json says the same, but for what a kill between the two renames left for later."""
        with open(self.folder / folder / "index.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        named = json.loads((self.folder / folder / "index.json").read_text())
        of_csv, of_json = ([(row["name"], row["state"], row["checksum"]) for row in index
                            if not after_kill or row["state"] == "done"] for index in (rows, named))
        if after_kill:
            self.assertLessEqual(set(of_json), set(of_csv))
        else:
            self.assertEqual(of_csv, of_json)
        return rows

    def checksums(self, folder="made"):
        return {row["name"]: row["checksum"] for row in self.index(folder)}

    def test_members_are_what_generate_makes_of_their_settings(self):
        self.write("bank.toml", 'base = "base.toml"\n[vary]\n"texture.seed" = "1:2"\n"filter.groups[0].sigma" = [0.7, 1.0]\n')
        done = self.bank("--json", "--progress", "none")
        self.assertEqual(json.loads(done.stdout), {"index": "made/index.csv", "done": 4, "members": 4})
        rows = self.index()
        self.assertEqual([row["name"] for row in rows], ["seed1_sigma0.7", "seed1_sigma1.0", "seed2_sigma0.7", "seed2_sigma1.0"])
        self.assertEqual({row["state"] for row in rows}, {"done"})
        self.run_program("generate", "base.toml", "-o", "one.h5", "--quiet", "--set", "texture.seed=2", "--set",
                         "filter.groups[0].sigma=0.7")
        one = self.info("one.h5")
        self.assertEqual(rows[2]["checksum"], one["checksums"]["/samples"])
        self.assertEqual((rows[2]["texture.seed"], rows[2]["filter.groups[0].sigma"]), ("2", "0.7"))
        self.assertAlmostEqual(float(rows[2]["relative_error"]), one["state"]["relative_error"], places=6)
        self.assertEqual(self.info("made/seed2_sigma0.7.h5")["checksums"], one["checksums"])
        # Members of one seed begin with the same random numbers, and are not held against each other.
        found = json.loads(self.study("verify", "made", "--json").stdout)
        self.assertEqual([found[key] for key in ("compared", "pairs", "pairs_of_one_seed", "alike", "sound")], [4, 4, 2, 4, True])
        self.bank("--resume", "--quiet", "--pack-into", "all.h5")
        with h5py.File(self.folder / "all.h5") as pack, h5py.File(self.folder / "one.h5") as alone:
            self.assertEqual(pack["samples"].shape, (4, *alone["samples"].shape))
            self.assertEqual(pack["samples"][2].tobytes(), alone["samples"][...].tobytes())
            self.assertEqual([name.decode() for name in pack["name"]], [row["name"] for row in rows])
            self.assertEqual(list(pack["settings/filter.groups[0].sigma"]), [0.7, 1.0, 0.7, 1.0])
            self.assertEqual([axis.label for axis in pack["samples"].dims], ["member", "t", "y", "x", "channel"])
        # The same of links, from wherever it is read; a member that is gone is no number.
        (self.folder / "packs").mkdir()
        self.bank("--resume", "--quiet", "--pack-into", "packs/links.h5", "--pack-links")
        self.assertLess((self.folder / "packs/links.h5").stat().st_size, (self.folder / "all.h5").stat().st_size)
        with h5py.File(self.folder / "packs/links.h5") as links, h5py.File(self.folder / "all.h5") as pack:
            self.assertEqual(links["samples"][...].tobytes(), pack["samples"][...].tobytes())
            self.assertEqual([axis.label for axis in links["samples"].dims], [axis.label for axis in pack["samples"].dims])
        (self.folder / "made/seed1_sigma1.0.h5").rename(self.folder / "away.h5")
        with h5py.File(self.folder / "packs/links.h5") as links:
            self.assertEqual([bool((member != member).all()) for member in links["samples"]], [False, True, False, False])
        (self.folder / "away.h5").rename(self.folder / "made/seed1_sigma1.0.h5")
        self.assertIn("--pack-into", self.bank("--resume", "--pack-links", expect=2).stderr)
        self.assertIn("all.h5: exists", self.bank("--resume", "--pack-into", "all.h5", expect=2).stderr)
        # Side by side, and the same bytes by groups of ranks.
        self.write("bank.toml", 'base = "base.toml"\ncombine = "side-by-side"\n[vary]\n"texture.seed" = [1, 2]\n'
                   '"filter.groups[0].sigma" = [0.7, 1.0]\n')
        done = self.run_program("bank", "bank.toml", "-o", "pairs", "--ranks-per-member", "2", ranks=3)
        self.assertNotIn("WARNING", done.stderr)
        pairs = self.checksums("pairs")
        self.assertEqual(pairs, {name: checksum for name, checksum in self.checksums().items() if name in pairs})
        self.assertEqual(list(pairs), ["seed1_sigma0.7", "seed2_sigma1.0"])

    def test_killed_at_random_nothing_is_made_twice_and_the_index_is_right(self):
        self.write("bank.toml", SEEDS % 12)
        self.bank("--quiet")
        expected = self.checksums()
        (self.folder / "made").rename(self.folder / "straight")
        made = {}
        between = 0
        for attempt in range(6):
            process = subprocess.Popen(self.command("bank", "bank.toml", "-o", "made", "--resume", "--threads", "2"),
                                       cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            for _ in range(1 + attempt % 2):
                process.stderr.readline()  # one member more is done
            process.send_signal(signal.SIGKILL)
            process.wait()
            process.stderr.close()
            done = sum(row["state"] == "done" for row in self.index(after_kill=True))
            self.assertGreater(done, 0)
            between += done < 12
            for row in self.index(after_kill=True):
                path = self.folder / "made" / f"{row['name']}.h5"
                if row["state"] != "done":
                    continue
                self.assertEqual(row["checksum"], expected[row["name"]])
                # The file of a member that is done is never written again.
                self.assertEqual(made.setdefault(row["name"], path.stat().st_mtime_ns), path.stat().st_mtime_ns)
        self.assertGreater(between, 0, "no kill fell between the first member and the last one")
        self.bank("--resume", "--quiet")
        self.assertEqual(self.checksums(), expected)
        for name, changed in made.items():
            self.assertEqual((self.folder / "made" / f"{name}.h5").stat().st_mtime_ns, changed)
        files = {path.name for path in (self.folder / "made").iterdir()}
        self.assertEqual(files, {"index.csv", "index.json", *(f"seed{seed}.h5" for seed in range(1, 13))})

    def test_commands_that_share_a_folder_share_the_work(self):
        self.write("bank.toml", SEEDS % 8)
        workers = [subprocess.Popen(self.command("bank", "bank.toml", "-o", "made", "--resume", "--threads", "1", "--progress", "json"),
                                    cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in range(3)]
        lines = [[json.loads(line) for line in worker.communicate(timeout=60)[1].splitlines()] for worker in workers]
        self.assertEqual([(one[-1]["event"], one[-1]["done"]) for one in lines], [("summary", 8)] * 3)
        said = [line for one in lines for line in one if line["event"] == "member"]
        self.assertEqual([worker.returncode for worker in workers], [0, 0, 0])
        self.assertEqual(sorted(line["member"] for line in said), sorted(f"seed{seed}" for seed in range(1, 9)))
        self.assertEqual({row["state"] for row in self.index()}, {"done"})

    def test_a_signal_or_the_time_limit_stops_it_saved(self):
        self.write("bank.toml", SEEDS % 3)
        long = ("--set", "optimizer.stop.iterations=2000000", "--threads", "2")
        self.bank(*long, "--time-limit", "0.3s", "--quiet", expect=75)
        self.assertIn("begun", {row["state"] for row in self.index()})
        process = subprocess.Popen(self.command("bank", "bank.toml", "-o", "made", "--resume", "--quiet", *long), cwd=self.folder)
        while not list((self.folder / "made").glob("seed*.lock")):
            self.assertIsNone(process.poll())
            time.sleep(0.02)
        self.assertEqual(len(list((self.folder / "made").glob(".at-work-*.lock"))), 1)
        process.send_signal(signal.SIGUSR1)
        self.assertEqual(process.wait(timeout=60), 75)
        self.assertEqual([name for name in os.listdir(self.folder / "made") if "tmp" in name or "lock" in name], [])

    def test_faults_are_said_all_at_once_and_nothing_is_started(self):
        for text, *words in (
                ('[vary]\n"texture.seed" = "1:3"\n', "base"),
                ('base = "base.toml"\n', "vary"),
                ('base = "nowhere.toml"\n[vary]\n"texture.seed" = "1:3"\n', "nowhere.toml"),
                ('base = "base.toml"\n[vary]\n"texture.seed" = "3:1"\n"texture.sede" = [1]\n', "bank.toml:3", '"3:1"'),
                ('base = "base.toml"\n[vary]\n"texture.sede" = [1]\n"filter.groups[0].sigma" = [-1, 1.0]\n', "bank.toml:3", 'did you mean "seed"',
                 "bank.toml:4", "-1"),
                ('base = "base.toml"\n[vary]\n"texture.seed" = [1, 2, 1]\n', "bank.toml:3", "vary.\"texture.seed\"", "twice"),
                ('base = "base.toml"\ncombine = "side-by-side"\n[vary]\n"texture.seed" = [1, 2, 1]\n"filter.groups[0].sigma" = [1.0, 2.0, 1.0]\n',
                 "bank.toml:4", "values 1 and 3", "twice"),
                ('base = "base.toml"\ncombine = "zip"\n[vary]\n"texture.seed" = [1, 1]\n', "side-by-side", "twice"),
                ('base = "base.toml"\ncombine = "side-by-side"\n[vary]\n"texture.seed" = [1]\n"filter.groups[0].sigma" = [1.0, 2.0]\n',
                 "same number"),
                ('base = "base.toml"\n[vary]\n"texture.seed" = "1:100000"\n"filter.groups[0].sigma" = [1.0, 2.0]\n', "100000 members")):
            with self.subTest(text):
                self.write("bank.toml", text)
                done = self.bank(expect=2)
                for word in words:
                    self.assertIn(word, done.stderr)
                self.assertFalse((self.folder / "made").exists())

    def contents(self):
        return {path.name: path.read_bytes() for path in (self.folder / "made").iterdir()}

    def test_a_pack_is_replaced_with_its_bank_and_nothing_else_is(self):
        self.write("bank.toml", SEEDS % 2)
        self.bank("--quiet", "--pack-into=all.h5")
        first = (self.folder / "all.h5").read_bytes()
        self.bank("--overwrite", "--quiet", "--pack-into", "all.h5", "--set", "optimizer.stop.iterations=70")
        self.assertNotEqual((self.folder / "all.h5").read_bytes(), first)
        before = self.contents()
        self.write("notes.txt", "mine")
        (self.folder / "seed.h5").write_bytes(before["seed1.h5"])
        for path, words in (("made/seed1.h5", "of the bank itself"), ("made/../made/index.csv", "of the bank itself"),
                            ("notes.txt", "is not a file that --pack-into made"), ("seed.h5", "is not a file that --pack-into made"),
                            ("nowhere/all.h5", "nowhere: there is no such folder")):
            with self.subTest(path):
                self.assertIn(words, self.bank("--overwrite", "--pack-into", path, expect=2).stderr)
                self.assertEqual(self.contents(), before)
        self.assertEqual((self.folder / "notes.txt").read_text(), "mine")

    def test_overwrite_removes_nothing_of_a_bank_that_is_being_made(self):
        self.write("bank.toml", SEEDS % 3)
        self.bank("--quiet")
        with open(self.folder / "made" / "seed3.h5.lock", "w") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            before = self.contents()
            self.assertIn("seed3.h5: another run is writing it", self.bank("--overwrite", expect=2).stderr)
            self.assertEqual(self.contents(), before)
        # Between two members a bank holds none of them, and says all the same that it is at work.
        with open(self.folder / "made" / ".at-work-0.lock", "w") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            before = self.contents()
            self.assertIn("another run is writing it", self.bank("--overwrite", expect=2).stderr)
            self.assertEqual(self.contents(), before)
        self.bank("--overwrite", "--quiet")

    def test_two_banks_are_not_made_in_one_folder_at_a_time(self):
        """Each would take the other's index and saves for its own."""
        self.write("bank.toml", SEEDS % 2)
        long = ("--set", "optimizer.stop.iterations=2000000")
        process = subprocess.Popen(self.command("bank", "bank.toml", "-o", "made", "--quiet", "--threads", "1", *long), cwd=self.folder)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)  # called before wait
        while not any(lock.stat().st_size for lock in (self.folder / "made").glob("seed*.lock")):
            self.assertIsNone(process.poll())
            time.sleep(0.02)
        index = {name: (self.folder / "made" / name).read_bytes() for name in ("index.csv", "index.json")}
        self.write("more.toml", SEEDS % 3)
        done = self.run_program("bank", "more.toml", "-o", "made", "--resume", *long, expect=2)
        self.assertIn("made: another bank is being made in this folder", done.stderr)
        self.assertIn(f"process {process.pid} on ", done.stderr)
        for name, content in index.items():
            self.assertEqual((self.folder / "made" / name).read_bytes(), content)
        self.bank("--resume", "--time-limit", "0.2s", "--threads", "1", *long, expect=75)  # the same one helps
        process.kill()
        process.wait()
        self.run_program("bank", "more.toml", "-o", "made", "--resume", *long, "--time-limit", "0.2s", expect=75)

    def test_what_others_hold_is_not_done(self):
        self.write("bank.toml", SEEDS % 3)
        (self.folder / "made").mkdir()
        with open(self.folder / "made" / "seed1.h5.lock", "w") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            for ranks in (None, 2):
                done = self.bank("--resume", "--pack-into", "all.h5", "--time-limit", "2s", ranks=ranks, expect=75)
                self.assertIn("2 of 3 members done", done.stdout)
                self.assertIn("no pack was made", done.stdout)
        self.bank("--resume", "--pack-into", "all.h5")
        self.assertTrue((self.folder / "all.h5").exists())

    def test_what_others_let_go_of_is_made(self):
        self.write("bank.toml", SEEDS % 3)
        (self.folder / "made").mkdir()
        held = open(self.folder / "made" / "seed1.h5.lock", "w")
        fcntl.flock(held, fcntl.LOCK_EX)
        process = subprocess.Popen(self.command("bank", "bank.toml", "-o", "made", "--resume", "--threads", "1"), cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for line in process.stderr:
            if line.startswith("2 of 3 done"):
                break
        held.close()
        rest = process.stderr.read()
        process.stderr.close()
        self.assertEqual(process.wait(timeout=60), 0, rest)
        self.assertIn("3 of 3 done: seed1", rest)

    def test_a_member_that_fails_is_left_out(self):
        self.write("bank.toml", SEEDS % 4)
        for folder in ("made/seed1.h5", "made/seed3.h5"):
            (self.folder / folder).mkdir(parents=True)
        for ranks in (2, None):
            done = self.bank("--resume", "--pack-into", "all.h5", ranks=ranks, expect=2)
            self.assertIn("seed1: made/seed1.h5: is a folder", done.stderr)
            self.assertIn("seed3: made/seed3.h5: is a folder", done.stderr)
            self.assertIn("2 of 4 members done: made/index.csv; others failed; no pack was made", done.stdout)

    def study(self, *arguments, expect=0):
        done = subprocess.run([BIN / "noiseloom-study", *arguments], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done

    def test_its_folder_is_verified_and_exported_as_a_covariance(self):
        self.write("bank.toml", SEEDS % 6)
        self.bank("--quiet", "--set", "texture.samples=gauss", "--set", "texture.size={x=13,y=11,t=3}")
        found = json.loads(self.study("verify", "made", "--json").stdout)
        self.assertEqual((found["members"], found["compared"], found["pairs"], found["sound"]), (6, 6, 15, True))
        self.assertLess(found["bands"][0]["power"], 0.3)  # blue
        self.study("export", "made", "-o", "made.npz", "--covariance")
        arrays = numpy.load(self.folder / "made.npz")
        planes = []
        for path in (self.folder / "made").glob("*.h5"):
            with h5py.File(path) as file:
                planes.append(file["samples"][...].reshape(3, 11, 13).astype("f8"))
        planes = numpy.concatenate(planes)
        numpy.testing.assert_allclose(arrays["mean"], planes.mean(axis=0), atol=1e-6)
        power = (abs(numpy.fft.fft2(planes - planes.mean())) ** 2).mean(axis=0) / 143
        numpy.testing.assert_allclose(arrays["spectrum"], numpy.maximum(power, 1e-6 * power.mean()), rtol=1e-4, atol=1e-6)
        factor = arrays["cholesky"].astype("f8")
        covariance = (factor @ factor.T).reshape(11, 13, 11, 13)
        expected = numpy.fft.ifft2(arrays["spectrum"]).real
        for y, x in ((0, 0), (4, 7)):
            numpy.testing.assert_allclose(covariance[y, x], numpy.roll(expected, (y, x), (0, 1)), atol=1e-5)
        self.assertIn(".npz", self.study("export", "made", "-o", "made.png", "--covariance", expect=2).stderr)
        said = self.study("export", "made", "-o", "no.npz", "--covariance", "--slices", "0:1", "--range", "0:2", "--format", "png",
                          expect=2).stderr
        for option in ("--slices 0:1", "--range 0:2", "--format png"):
            self.assertIn(f"{option}: does not go with --covariance", said)
        for option, value in (("--pack", "R=seed1"), ("--importance", "map.npy")):
            said = self.study("export", "made/seed1.h5", "-o", "no.npz", "--covariance", option, value, expect=2).stderr
            self.assertIn(f"does not go with {option}", said)
        self.assertFalse((self.folder / "no.npz").exists())
        # A run that is not finished is exported with the same warning as elsewhere.
        self.run_program("generate", "base.toml", "-o", "long.h5", "--quiet", "--set", "optimizer.stop.iterations=2000000",
                         "--time-limit", "0.2s", expect=75)
        done = self.study("export", "long.h5", "-o", "long.npz", "--covariance", "--json")
        self.assertEqual(json.loads(done.stdout), {"files": ["long.npz"], "tables": [], "planes": 4, "members": 1})
        self.assertIn("warning: long.h5: not finished", done.stderr)
        # One member in the place of another.
        (self.folder / "made/seed4.h5").write_bytes((self.folder / "made/seed2.h5").read_bytes())
        self.assertIn("seed2 and seed4 are correlated", self.study("verify", "made", expect=3).stdout)
        self.write("bank.toml", SEEDS % 1)
        self.run_program("bank", "bank.toml", "-o", "one", "--quiet")
        self.assertIn("fewer than two members", self.study("verify", "one", expect=2).stderr)

    def test_members_that_do_not_fit_into_a_pack_are_said_on_ranks(self):
        self.write("bank.toml", 'base = "base.toml"\n[vary]\n"texture.size.t" = [3, 4]\n')
        self.assertIn("not packed into one array", self.bank("--pack-into", "all.h5", ranks=2, expect=2).stderr)
        said = self.study("verify", "made").stdout
        self.assertIn("2 members, 0 of them compared, 0 pairs\nleft out: 1 pair of different sizes", said)
        self.assertNotIn("uncorrelated", said)

    def test_a_rank_that_fails_alone_ends_all(self):
        self.write("bank.toml", SEEDS % 2)
        starve = self.write("starve.sh", '[ "$OMPI_COMM_WORLD_RANK" != 1 ] || ulimit -v 300000\nexec "$@"\n')
        command = self.command("bank", "bank.toml", "-o", "made", "--ranks-per-member", "2", "--set",
                               "texture.size={x=2048,y=2048,t=8}", ranks=2)
        command[3:3] = ["bash", str(starve)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder, timeout=60)
        self.assertNotEqual(done.returncode, 0, done.stderr)

    def test_only_locks_of_the_dead_are_removed(self):
        self.write("bank.toml", SEEDS % 3)
        self.bank("--quiet")
        locks = [self.folder / "made" / f"seed{seed}.h5.lock" for seed in (1, 2)]
        locks[0].write_text("process 1 on elsewhere\nmachine elsewhere\npid 1\nstarted 1\nnumber 12\n")
        before_it = self.folder / "made" / ".at-work-0.lock"
        before_it.write_text("")
        locks[1].write_text("")  # of this machine, as nobody has locked it
        before = locks[0].stat()
        self.bank("--resume", "--quiet")
        self.assertFalse(locks[1].exists())
        self.assertFalse(before_it.exists())
        self.assertEqual((locks[0].stat().st_ino, locks[0].stat().st_mtime_ns), (before.st_ino, before.st_mtime_ns))

    def test_what_a_folder_holds_is_kept(self):
        self.write("bank.toml", SEEDS % 1)
        self.bank("--quiet")
        before = (self.folder / "made" / "seed1.h5").read_bytes()
        self.assertIn("--resume", self.bank(expect=2).stderr)
        self.assertIn("another config", self.bank("--resume", "--set", "optimizer.stop.iterations=70", expect=2).stderr)
        self.assertEqual((self.folder / "made" / "seed1.h5").read_bytes(), before)
        self.write("bank.toml", SEEDS % 2)  # more seeds
        self.bank("--resume", "--quiet")
        self.assertEqual((self.folder / "made" / "seed1.h5").read_bytes(), before)
        self.assertEqual(len(self.index()), 2)
        self.bank("--overwrite", "--quiet", "--set", "optimizer.stop.iterations=70")
        self.assertNotEqual((self.folder / "made" / "seed1.h5").read_bytes(), before)
        self.write("made.h5", "")
        self.assertIn("not a folder", self.run_program("bank", "bank.toml", "-o", "made.h5", expect=2).stderr)


if __name__ == "__main__":
    main()
