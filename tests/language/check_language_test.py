#!/usr/bin/env python3
"""Tests tools/scripts/check_language.py: check_language_test.py CHECK_LANGUAGE"""

import contextlib
import io
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(sys.argv.pop(1)).parent))
sys.dont_write_bytecode = True
import check_language
import language_rules
from language_rules import broken_rules, is_flagged
from language_sentences import read_sentences

# Each bad sentence with a rule that it breaks.
BAD = [
    ("What is kept of a keyframe.", "clause-first"),
    ("Whatever hides the model may be new.", "clause-first"),
    ("Who shows a run, as pages in browsers do.", "clause-first"),
    ("How other types are texts.", "clause-first"),
    ("That a frame has no pose is not an error.", "clause-first"),
    ("Where intensities count every frame gets its own.", "where-for-if"),
    ("Wherever fewer have a pose the result is in doubt.", "where-for-if"),
    ("The session keeps what the run knows.", "clause-as-noun"),
    ("A page for those and for who may watch.", "clause-as-noun"),
    ("Removes everything that was not seen.", "clause-as-noun"),
    ("Of two surfels the less confident is removed.", "of-first"),
    ("Errors of depth: of near points they are small.", "of-first"),
    ("By how much colour is earlier than frames.", "preposition-first"),
    ("From the second keyframe the graph is solved.", "preposition-first"),
    ("Removed are surfels that overlap.", "inversion"),
    ("Not drawn are discs seen at the back.", "inversion"),
    ("The motion over lost frames is left out, nor is a jump counted.", "inversion"),
    ("Loops are rejected, and so are the edges of lost frames.", "inversion"),
    ("All frames but for lost frames are written.", "but-for"),
    ("Uses all but skipped frames of the sequence.", "but-for"),
    ("Frames from the third keyframe on are fused.", "from-on"),
    ("After so many lost frames a new map is begun.", "open-quantity"),
    ("The map is rendered so often during a run.", "open-quantity"),
    ("Keeps half as many frames on the coarser level.", "open-quantity"),
    ("The same of a frame at the pose of a keyframe.", "same-of"),
    ("The camera turns, and the map does likewise.", "same-of"),
    ("The pose is the last of the sequence.", "headless-adjective"),
    ("Two cameras see the wall, and the second is slower.", "headless-adjective"),
    ("The median error of the poses is .71 mm here.", "bare-decimal"),
    ("Both are the sensor's, and those that it measured.", "possessive-without-noun"),
    ("Images were asked as the map says nothing.", "speech-verb"),
    ("It tells the camera by the data.", "pronoun-first"),
    ("These are of the frames that others have seen through.", "pronoun-first"),
    ("Data that the camera measured comes to the map anew.", "late-adverb"),
    ("The weight is as large as it can be, and those of others are not.", "unfinished-clause"),
    ("Views without a pose, as they are.", "as-clause"),
    ("Those that a keyframe is joined to.", "pronoun-with-clause"),
    ("The map goes by the poses of frames, as given.", "private-word"),
    (
        "The residual, the covariance of the pose and the rendered depth of the model are written to the folder of"
        " the run after each frame of the sequence that tracking has lost.",
        "long",
    ),
]

GOOD = [
    "Data stored per keyframe.",
    "Uncertainty added to pose graph edges.",
    "Removes the less confident of two overlapping surfels.",
    "Discs seen from behind are not drawn.",
    "Occluders are in front of the scene, so features behind them count twice.",
    "Adds a frame at the pose of the last frame.",
    "Colour latency in seconds.",
    "If the photometric weight is positive, the map is rendered for every frame.",
    "Number of consecutive lost frames before a new submap starts.",
    "Writes all frames except lost and skipped frames.",
    "Candidate keyframe for the query view.",
    "The feature check found two motions.",
    "Returns `std::nullopt` without a motion prior.",
    "The median error is 0.71 mm.",
    "Standard deviation of the motion prior, m. 0: no prior.",
    "Dormant surfels are not removed: there are fewer frames than `max_inactive_frames`.",
    "colour exposure time, s; 0: no motion blur",
    "do not wait for loop closure and calibration",
    "out of memory with 31 million surfels: set --max_map_points",
    "Every `map_period`-th tracked frame is fused and gets a new model view.",
    "True if the pose is degenerate or weakly constrained.",
    "Returns false when the queue is empty.",
    "Task results are applied after a fixed number of frames, so results do not depend on the machine.",
    "An insignificant change of the calibration is discarded.",
    "Global registration also runs below this inlier ratio.",
    "Repetitive texture pulls weakly constrained registrations to a wrong minimum.",
    "Factor of the robust kernel width per coarser level.",
    "How to add a residual to the library.",
    "By default, the first pose is fixed.",
    "From here, the solver uses double precision.",
    "Where w is the weight of the residual.",
    "The rotation is applied first, then the translation.",
    "See https://example.org/what-is-kept for the derivation.",
    "Throws InputError if the file does not exist.",
    "The caller owns the image, which must outlive the view.",
    "Converts the point from the camera frame to the world frame.",
    "Is this frame a keyframe?",
    "The result is independent of the number of threads.",
    "`What is kept` is a bad name of a table.",
]


class RulesTest(unittest.TestCase):
    def test_flags_bad_sentences(self):
        self.assertGreaterEqual(len(BAD), 30)
        for text, rule in BAD:
            with self.subTest(text):
                broken = broken_rules(text)
                self.assertIn(rule, broken)
                self.assertTrue(is_flagged(broken), broken)

    def test_accepts_good_sentences(self):
        self.assertGreaterEqual(len(GOOD), 30)
        for text in GOOD:
            with self.subTest(text):
                broken = broken_rules(text)
                self.assertFalse(is_flagged(broken), broken)

    def test_every_rule_has_a_bad_sentence(self):
        marks = {rule.name: rule.marks for rule in language_rules.RULES}
        tested = {rule for _, rule in BAD}
        self.assertEqual({name for name in marks if marks[name] > 1} - tested, set())

    def test_every_rule_has_advice(self):
        for text, _ in BAD:
            for rule in broken_rules(text):
                self.assertTrue(language_rules.ADVICE[rule])

    def test_accepts_25_words_and_flags_26(self):
        text = " ".join(["The"] + ["frame"] * 24)
        self.assertNotIn("long", broken_rules(text + " 12 + 0.5 * x^2 n . R."))
        self.assertIn("long", broken_rules(text + " frame."))

    def test_accepts_pronoun_after_another_sentence(self):
        text = "It says how the map was rendered."
        self.assertIn("pronoun-first", broken_rules(text, follows=False))
        self.assertNotIn("pronoun-first", broken_rules(text, follows=True))


class FolderTest(unittest.TestCase):
    """A temporary folder, which replaces the source tree."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        for name, value in ("ROOT", self.root), ("EXCEPTIONS", self.root / "exceptions.txt"):
            self.addCleanup(setattr, check_language, name, getattr(check_language, name))
            setattr(check_language, name, value)

    def write(self, name, text):
        (self.root / name).parent.mkdir(parents=True, exist_ok=True)
        (self.root / name).write_text(text)
        return self.root / name

    def run_main(self, *arguments):
        """The exit code and the output of the program."""
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
            try:
                code = check_language.main([str(argument) for argument in arguments])
            except SystemExit as exit_call:
                code = exit_call.code
        return code, output.getvalue()


class ReadersTest(FolderTest):
    def read(self, name, text):
        sentences = read_sentences(self.write(name, text))
        return [(s.first_line, s.last_line, s.text) for s in sentences]

    def test_joins_line_comments(self):
        text = "int a;\n// The first sentence has\n// two lines. The second sentence has one.\nint b;\n"
        expected = [(2, 3, "The first sentence has two lines."), (3, 3, "The second sentence has one.")]
        self.assertEqual(self.read("a.cc", text), expected)

    def test_separates_trailing_comments(self):
        text = "int a;  // width of the image, px\nint b;  // height of the image, px\n"
        expected = [(1, 1, "width of the image, px"), (2, 2, "height of the image, px")]
        self.assertEqual(self.read("a.h", text), expected)

    def test_reads_block_comments(self):
        text = "/**\n * Returns the depth in metres.\n */\nfloat Depth();\n"
        self.assertEqual(self.read("a.h", text), [(2, 2, "Returns the depth in metres.")])

    def test_ignores_strings_with_comment_marks(self):
        text = 'const char* a = "// What is in a string"; const char* b = R"(// What is in a raw string)";\n'
        self.assertEqual(self.read("a.cc", text), [])

    def test_reads_help_texts_of_flags(self):
        text = (
            'v.Add(a, "name", Range(1, 2),\n      "number of threads "\n      "of the solver");\n'
            'Log("no help text, I think");\n'
        )
        self.assertEqual(self.read("a.cc", text), [(2, 3, "number of threads of the solver")])

    def test_reads_help_text_after_a_lambda(self):
        text = (
            'm.def("f", [](int a) { return Text("not a help text (at all)"); },'
            ' "Returns the number of frames.");\n'
        )
        self.assertEqual(self.read("a.cc", text), [(1, 1, "Returns the number of frames.")])

    def test_skips_code_and_licences(self):
        text = "// Copyright of all of the authors.\n\n// for (int i = 0; i < 3; ++i) {\n//   a(b, c);\n// }\n"
        self.assertEqual(self.read("a.cc", text), [])

    def test_skips_indented_code_but_not_list_items(self):
        text = (
            "// Prints the errors of a run:\n//   print_errors the folder of the run\n"
            "// - errors of all\n//   poses of the run\n"
        )
        expected = [(1, 1, "Prints the errors of a run:"), (3, 4, "errors of all poses of the run")]
        self.assertEqual(self.read("a.cc", text), expected)

    def test_skips_indented_code_in_docstrings(self):
        text = (
            'def f():\n    """Prints the errors of a run.\n\n        f(the folder of a run)\n\n'
            '    Returns the number of errors.\n    """\n'
        )
        expected = [(2, 2, "Prints the errors of a run."), (6, 6, "Returns the number of errors.")]
        self.assertEqual(self.read("a.py", text), expected)

    def test_separates_list_items(self):
        text = "// - depth image in metres, float\n// - colour image with three channels\n"
        expected = [(1, 1, "depth image in metres, float"), (2, 2, "colour image with three channels")]
        self.assertEqual(self.read("a.h", text), expected)

    def test_reads_python(self):
        text = (
            '"""Prints the errors of a run."""\nx = "# not a comment at all"  # number of frames per second\n'
            'parser.add_argument("--a", help="folder with the results of a run")\n'
        )
        expected = [
            (1, 1, "Prints the errors of a run."),
            (2, 2, "number of frames per second"),
            (3, 3, "folder with the results of a run"),
        ]
        self.assertEqual(self.read("a.py", text), expected)

    def test_reads_cmake(self):
        text = (
            "# Builds the programs for the tests.\noption(TOOLS \"build the programs of the library\" ON)\n"
            'set(SECONDS 600 CACHE STRING "seconds of fuzzing for each target")\nmessage("a # is not a comment here")\n'
        )
        expected = [
            (1, 1, "Builds the programs for the tests."),
            (2, 2, "build the programs of the library"),
            (3, 3, "seconds of fuzzing for each target"),
        ]
        self.assertEqual(self.read("CMakeLists.txt", text), expected)

    def test_reads_shell(self):
        text = "#!/usr/bin/env bash of all users\n# Runs the tests in Release.\necho \"no # comment is in here\"\n"
        self.assertEqual(self.read("a.sh", text), [(2, 2, "Runs the tests in Release.")])

    def test_reads_paragraphs_and_cells_of_markdown(self):
        text = (
            "# The title is not a sentence\n\nThe first paragraph has a [link to a page](page.md).\n\n"
            "    code is not read at all\n\n| option of the solver | number of the iterations |\n|---|---|\n"
        )
        expected = [
            (3, 3, "The first paragraph has a link to a page."),
            (7, 7, "number of the iterations"),
            (7, 7, "option of the solver"),
        ]
        self.assertEqual(self.read("a.md", text), expected)


class ProgramTest(FolderTest):
    BAD = "// What is kept of a keyframe.\n"
    GOOD = "// Data that is stored per keyframe.\n"

    def test_lists_flagged_sentences_of_a_folder(self):
        self.write("src/a.cc", self.GOOD + "int a;\n" + self.BAD)
        self.write("build/b.cc", self.BAD)
        code, output = self.run_main(self.root)
        self.assertEqual(code, 1)
        self.assertIn("src/a.cc:3: What is kept of a keyframe.\n    clause-first: ", output)
        self.assertNotIn("b.cc", output)

    def test_accepts_good_files(self):
        path = self.write("src/a.cc", self.GOOD)
        self.assertEqual(self.run_main(path)[0], 0)

    def test_rejects_missing_path_and_missing_arguments(self):
        self.assertEqual(self.run_main(self.root / "missing")[0], 2)
        self.assertEqual(self.run_main()[0], 2)

    def test_accepts_exceptions(self):
        self.write("src/a.cc", self.BAD)
        self.write("exceptions.txt", "# A comment.\n\nsrc/a.cc | is kept of | a quotation\n")
        self.assertEqual(self.run_main(self.root)[0], 0)

    def test_rejects_unused_exception(self):
        self.write("src/a.cc", self.GOOD)
        self.write("src/b.cc", self.GOOD)
        self.write("exceptions.txt", "src/a.cc | is kept of | a quotation\n")
        code, output = self.run_main(self.root)
        self.assertEqual(code, 1)
        self.assertIn("exceptions.txt:1: src/a.cc has no flagged sentence with 'is kept of'", output)
        self.assertEqual(self.run_main(self.root / "src/b.cc")[0], 0)

    def test_rejects_exception_of_a_missing_file(self):
        self.write("src/a.cc", self.GOOD)
        self.write("exceptions.txt", "src/missing.cc | is kept of | a quotation\n")
        self.assertEqual(self.run_main(self.root)[0], 1)

    def test_rejects_exception_without_reason(self):
        self.write("src/a.cc", self.BAD)
        self.write("exceptions.txt", "src/a.cc | is kept of\n")
        code, output = self.run_main(self.root)
        self.assertEqual(code, 1)
        self.assertIn("exceptions.txt:1: must be", output)

    def test_checks_nothing_outside_of_git(self):
        self.write("src/a.cc", self.BAD)
        code, output = self.run_main("--changed")
        self.assertEqual(code, 0)
        self.assertIn("not checked: ", output)


@unittest.skipUnless(shutil.which("git"), "git is not installed")
class ChangedTest(FolderTest):
    BAD = ProgramTest.BAD
    GOOD = ProgramTest.GOOD

    def setUp(self):
        super().setUp()
        self.git("init", "-q", "-b", "main")

    def git(self, *arguments):
        identity = ["-c", "user.name=Test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", "-C", str(self.root), *identity, *arguments], check=True, capture_output=True)

    def commit(self, name, text):
        self.write(name, text)
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "Change " + name)

    def test_checks_nothing_without_previous_commit(self):
        self.commit("a.cc", self.BAD)
        code, output = self.run_main("--changed")
        self.assertEqual(code, 0)
        self.assertIn("not checked: there is no previous commit", output)

    def test_compares_with_the_previous_commit_on_the_main_branch(self):
        self.commit("a.cc", self.BAD + "int a;\n")
        self.commit("a.cc", self.BAD + "int a;\n" + self.GOOD)
        self.assertEqual(self.run_main("--changed")[0], 0)
        self.commit("a.cc", self.BAD + "int a;\n" + self.BAD)
        code, output = self.run_main("--changed")
        self.assertEqual(code, 1)
        self.assertIn("a.cc:3: ", output)
        self.assertNotIn("a.cc:1: ", output)

    def test_compares_a_branch_with_its_merge_base(self):
        self.commit("a.cc", self.BAD)
        self.git("checkout", "-q", "-b", "topic")
        self.commit("b.cc", self.BAD)
        self.commit("c.cc", self.GOOD)
        code, output = self.run_main("--changed")
        self.assertEqual(code, 1)
        self.assertIn("b.cc:1: ", output)
        self.assertNotIn("a.cc", output)

    def test_compares_with_the_given_commit(self):
        self.commit("a.cc", self.GOOD)
        self.commit("b.cc", self.BAD)
        self.commit("c.cc", self.GOOD)
        self.assertEqual(self.run_main("--changed")[0], 0)
        self.assertEqual(self.run_main("--changed", "HEAD~2")[0], 1)
        self.assertEqual(self.run_main("--changed", "missing")[0], 2)

    def test_checks_uncommitted_and_new_files(self):
        self.commit("a.cc", self.GOOD)
        self.commit("b.cc", self.GOOD)
        self.write("c.cc", self.BAD)
        self.assertIn("c.cc:1: ", self.run_main("--changed")[1])
        self.write("b.cc", self.BAD)
        self.assertIn("b.cc:1: ", self.run_main("--changed")[1])

    def test_ignores_removed_and_renamed_files(self):
        self.commit("a.cc", self.BAD + "int a;\n" * 20)
        self.commit("b.cc", self.GOOD)
        self.git("mv", "a.cc", "c.cc")
        self.git("rm", "-q", "b.cc")
        self.assertEqual(self.run_main("--changed")[0], 0)

    def test_rejects_unused_exceptions(self):
        self.commit("a.cc", self.GOOD)
        self.commit("b.cc", self.GOOD)
        self.write("exceptions.txt", "a.cc | is kept of | a quotation\n")
        self.assertEqual(self.run_main("--changed")[0], 1)


if __name__ == "__main__":
    unittest.main()
