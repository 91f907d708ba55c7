"""What read_models.py says of readers that are not there: it names what nobody has read, and asks for them again the next time."""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import read_models  # noqa: E402  beside this file


class Unread(unittest.TestCase):
    def setUp(self):
        read_models.unread.clear()
        read_models.failures.clear()

    def said(self):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            status = read_models.conclude()
        return status, out.getvalue().splitlines()

    def test_topics_that_nobody_reads_are_not_judged(self):
        with mock.patch.dict(sys.modules, {"cyclonedds": None}):
            read_models.read_topics(pathlib.Path("."), {}, pathlib.Path("."))
        status, lines = self.said()
        self.assertEqual(status, 0)
        self.assertTrue(lines[0].startswith("SKIPPED cyclonedds: not read: rt/octomap_binary and rt/object_points"), lines)
        self.assertEqual(lines[-1], "all hold of what was read")

    def test_a_reader_is_named_once_with_all_that_it_leaves_unread(self):
        with mock.patch.dict(sys.modules, {"pyoctomap": None}), mock.patch.object(read_models.shutil, "which", return_value=None):
            read_models.read_trees(pathlib.Path("."), {})
            read_models.read_trees(pathlib.Path("."), {})
            read_models.read_with_octomap_tools(pathlib.Path("."), {})
        _, lines = self.said()
        self.assertEqual([line.split(":")[0] for line in lines[:-1]], ["SKIPPED pyoctomap", "SKIPPED octomap-tools"])

    def test_all_read(self):
        self.assertEqual(self.said(), (0, ["all hold"]))

    def test_what_does_not_hold_fails_whatever_is_unread(self):
        read_models.skipped("cyclonedds", "topics", "no wheel")
        with contextlib.redirect_stdout(io.StringIO()):
            read_models.hold("a truth", False)
        status, lines = self.said()
        self.assertEqual((status, lines[-1]), (1, "1 do not hold"))


class Installing(unittest.TestCase):
    def run_install(self, work, there):
        """Packages asked for, where pip has those of `there` alone."""
        asked = []

        def installed(command, _seconds):
            packages = [word for word in command[1:] if word in read_models.NEEDED + read_models.OPTIONAL]
            asked.extend(packages)
            return all(package in there for package in packages)

        with mock.patch.object(read_models, "installed", installed), mock.patch.object(read_models.venv, "create", lambda home, **_: pathlib.Path(home).mkdir(exist_ok=True)), \
                contextlib.redirect_stdout(io.StringIO()):
            read_models.install(pathlib.Path(work))
        return asked

    def test_what_could_not_be_had_is_asked_for_again(self):
        everything = read_models.NEEDED + read_models.OPTIONAL
        with tempfile.TemporaryDirectory() as work:
            self.assertEqual(self.run_install(work, [p for p in everything if p != "cyclonedds"]), everything)
            self.assertEqual(self.run_install(work, []), ["cyclonedds"])
            self.assertEqual(self.run_install(work, ["cyclonedds"]), ["cyclonedds"])
            self.assertEqual(self.run_install(work, everything), [])


if __name__ == "__main__":
    unittest.main()
