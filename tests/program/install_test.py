"""What `cmake --install` puts in place works there, and can be taken away again."""

import os
import pathlib
import re
import shutil
import subprocess

from support import SOURCE, ProgramTest, main

BUILD = pathlib.Path(os.environ["NOISELOOM_BUILD_DIR"])
CMAKE = os.environ["NOISELOOM_CMAKE"]

SMALL = """
[texture]
size = { x = 8, y = 8 }
samples = "uniform"
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 1 }
"""


class Install(ProgramTest):
    def setUp(self):
        super().setUp()
        self.prefix = self.folder / "prefix"
        manifest = BUILD / "install_manifest.txt"  # of what a user may have installed from this build
        before = manifest.read_bytes() if manifest.exists() else None
        self.addCleanup(lambda: manifest.unlink(missing_ok=True) if before is None else manifest.write_bytes(before))
        subprocess.run([CMAKE, "--install", BUILD, "--prefix", self.prefix], check=True, capture_output=True, timeout=120)

    def complete(self, *words):
        """What bash proposes for the last of these words."""
        script = (f'source {self.prefix}/share/bash-completion/completions/noiseloom; COMP_WORDS=("$@"); '
                  f'COMP_CWORD=$(($# - 1)); _noiseloom {self.prefix}/bin/noiseloom; printf "%s\\n" "${{COMPREPLY[@]}}"')
        done = subprocess.run(["bash", "-c", script, "bash", "noiseloom", *words], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return set(done.stdout.split())

    def commands(self):
        return set(re.findall(r"^  noiseloom ([a-z][-a-z]*) ", self.run_program("--help").stdout, re.MULTILINE))

    def options_of(self, command):
        text = self.run_program(command, "--help").stdout
        return set(re.findall(r"^  (?:-\w,)?(--[-a-zA-Z]+)", text, re.MULTILINE))

    def test_files(self):
        names = {str(path.relative_to(self.prefix)) for path in self.prefix.rglob("*") if path.is_file()}
        for name in ("bin/noiseloom", "bin/noiseloom-study", "share/man/man1/noiseloom.1", "share/noiseloom/configs/quick.toml",
                     "share/noiseloom/slurm/generate.sbatch", "share/doc/noiseloom/LICENSE",
                     "share/bash-completion/completions/noiseloom", "share/zsh/site-functions/_noiseloom",
                     "share/fish/vendor_completions.d/noiseloom.fish"):
            self.assertIn(name, names)
        for name in names:
            if name.startswith("share/noiseloom/configs/"):
                self.assertTrue(name.endswith(".toml"), name)
        done = subprocess.run([self.prefix / "bin/noiseloom", "plan", self.prefix / "share/noiseloom/configs/quick.toml"], capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_images_are_read_and_written(self):
        (module,) = self.prefix.rglob("noiseloom-images.so")
        module = module.relative_to(self.prefix)
        config = self.write("c.toml", SMALL)
        for words in ("generate", config, "-o", "run.h5"), ("export", "run.h5", "-o", "a.png"), ("score", "a.png", "--config", config):
            done = subprocess.run([self.prefix / "bin/noiseloom", *words], capture_output=True, text=True, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
        # Programs that are linked with the installed package look for the module where it is.
        (package,) = self.prefix.rglob("noiseloom.cmake")
        self.assertIn(f"-Wl,-rpath,${{_IMPORT_PREFIX}}/{module.parent}", package.read_text())

    def test_manual_page_has_every_command_and_option(self):
        page = (self.prefix / "share/man/man1/noiseloom.1").read_text()
        plain = page.replace("\\-", "-").replace("\\&", "").replace("\\e", "\\")
        for command in self.commands():
            self.assertIn(f"\n.SS {command}\n", page)
            self.assertIn(self.run_program(command, "--help").stdout, plain)
        self.assertIn(self.run_program("--help-config").stdout, plain)
        self.assertIn(self.run_program("bank", "--help-bank").stdout, plain)
        requests = {line.split()[0] for line in page.splitlines() if line.startswith((".", "'"))}
        self.assertEqual(requests, {".TH", ".SH", ".SS", ".nf", ".fi"})
        pages = {path.stem for path in (self.prefix / "share/man/man1").iterdir()}
        self.assertEqual(pages, {"noiseloom"} | {f"noiseloom-{command}" for command in self.commands()})
        own = (self.prefix / "share/man/man1/noiseloom-export.1").read_text().replace("\\-", "-").replace("\\&", "")
        self.assertIn(self.run_program("export", "--help").stdout, own)
        self.assertIn("noiseloom-export - run file to images", own)

    def test_completion_proposes_what_the_program_knows(self):
        commands = self.complete("")
        self.assertLessEqual({"generate", "export", "accuracy"}, self.commands())
        self.assertEqual(commands, self.commands() | {"--help-config", "--version"})
        self.assertEqual(self.complete("ex"), {"export"})
        for command in self.commands():
            self.assertGreater(len(self.options_of(command)), 1)
            self.assertEqual(self.complete(command, "--"), self.options_of(command), command)
        self.assertEqual(self.complete("generate", "--res"), {"--resume"})
        self.assertEqual(self.complete("generate", "run"), set())  # files, which bash itself proposes

    def complete_in(self, shell, script, *words):
        """What zsh or fish proposes for the last of these words."""
        done = subprocess.run([shutil.which(shell), *script, *words], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return {line.split("\t")[0] for line in done.stdout.splitlines()}

    def test_completion_of_zsh_and_fish_is_that_of_bash(self):
        program = str(self.prefix / "bin/noiseloom")
        # zsh's own part, which shows what it is given, is left out.
        zsh = ["-f", "-c", 'compadd() { print -l -- ${(P)@[-1]} }; _files() { print FILES }; words=("$@"); CURRENT=$#; '
               f"source {self.prefix}/share/zsh/site-functions/_noiseloom", "zsh"]
        for words in ([""], ["generate", "--"], ["fastnoise", "-"]):
            expected = self.complete(*words)
            with self.subTest(shell="zsh", words=words):
                if shutil.which("zsh") is None:
                    self.skipTest("zsh is not installed")
                self.assertEqual({word for word in self.complete_in("zsh", zsh, program, *words) if word.startswith(words[-1])}, expected)
            with self.subTest(shell="fish", words=words):
                if shutil.which("fish") is None:
                    self.skipTest("fish is not installed")
                line = " ".join([program, *words])
                fish = ["--no-config", "-c", f'source {self.prefix}/share/fish/vendor_completions.d/noiseloom.fish; complete -C "{line}"']
                self.assertEqual(self.complete_in("fish", fish), expected)

    def test_uninstall_leaves_what_is_somebody_elses(self):
        other = self.prefix / "share" / "somebody" / "else.txt"
        other.parent.mkdir()
        other.write_text("x")
        command = [CMAKE, f"-DMANIFEST={BUILD / 'install_manifest.txt'}", "-P", SOURCE / "tools" / "uninstall.cmake"]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        self.assertEqual([path for path in self.prefix.rglob("*") if path.is_file()], [other])
        other.unlink()
        other.parent.rmdir()
        subprocess.run(command, check=True, capture_output=True, timeout=120)  # a second time harms nothing


if __name__ == "__main__":
    main()
