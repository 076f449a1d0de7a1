"""The package as it was installed, beside the program of the command line."""

import os
import pathlib
import re
import subprocess
import unittest

import numpy as np
import robovec

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARM = ROOT / "examples/robots/arm.urdf"
BOGIE = ROOT / "examples/models/bogie.mbs"
SUSPENSION = ROOT / "examples/suspension/mbs_dirdyna_suspension.m"


def states(program, count, seed=1):
    """Random states of all inputs that are no parameters."""
    draw = np.random.default_rng(seed)
    known = program.parameters()
    shapes = program.inputs.items()
    return {n: draw.uniform(-1, 1, (count, *s)) for n, s in shapes if n not in known}


class Reading(unittest.TestCase):
    def test_shapes_are_those_of_the_model(self):
        arm = robovec.load(ARM, "dirdyna")
        joints = arm.inputs["q"][0]
        self.assertEqual(arm.outputs["M"], (joints, joints))
        self.assertEqual(arm.inputs["dpt"][0], 3)
        self.assertIn("function dirdyna", str(arm))

    def test_what_is_wrong_is_an_exception_with_the_place(self):
        wrong = [
            lambda: robovec.load("no such file.mbs"),
            lambda: robovec.load(ARM, "no such function"),
            lambda: robovec.load(ARM, formulation="no such formulation"),
            lambda: robovec.parse("// robovec 1\nfunction f {"),
            lambda: robovec.load(ARM).run("no-such-pass"),
            lambda: robovec.load(ARM).run("atomise", machine="no such machine"),
            lambda: robovec.load(ARM)(q=[0.0]),
            lambda: robovec.load(ARM)(x=[0.0]),
            lambda: robovec.load(ARM)(number="f31"),
            lambda: robovec.load(SUSPENSION)(q=np.zeros(5)),
            lambda: robovec.load(ARM).compile(compiler="no-such-compiler"),
            lambda: robovec.load(ARM).plot_schedule(),
        ]
        for call in wrong:
            with self.assertRaises((robovec.Error, ImportError)):
                call()
        with self.assertRaisesRegex(robovec.Error, r"<text>:2"):
            robovec.parse("// robovec 1\nfunction f {")


class Evaluating(unittest.TestCase):
    def test_results_are_those_of_the_command_line_bit_for_bit(self):
        program = os.environ.get("ROBOVEC", str(ROOT / "target/release/robovec"))
        for path, function in [(BOGIE, "dirdyna"), (BOGIE, "accelred"), (ARM, "invdyna_d")]:
            loaded = robovec.load(path, function)
            given = states(loaded, 7)
            lines = []
            for state in range(7):
                lines.append("state")
                for name, array in given.items():
                    for index in np.ndindex(array.shape[1:]):
                        place = ",".join(str(i + 1) for i in index)
                        element = f"{name}[{place}]" if place else name
                        lines.append(f"{element} {float(array[state][index]).hex()}")
            file = pathlib.Path(os.environ.get("TMPDIR", "/tmp")) / f"states-{os.getpid()}"
            file.write_text("\n".join(lines) + "\n")
            for number in ["f64", "f32", "float(8,17)"]:
                command = [program, "eval", str(path), "--function", function]
                command += ["--states", str(file), "--number", number, "--hexadecimal"]
                told = subprocess.run(command, capture_output=True, text=True, check=True)
                found = loaded(number=number, **given)
                seen = 0
                for line in told.stdout.splitlines():
                    match = re.fullmatch(r"state (\d+) \w+ (\w+)(?:\[([\d,]+)\])? (\S+)", line)
                    at, name, place, value = match.groups()
                    index = tuple(int(i) - 1 for i in place.split(",")) if place else ()
                    computed = found[name][int(at) - 1][index]
                    self.assertEqual(float(computed).hex(), float.fromhex(value).hex(), line)
                    seen += 1
                self.assertGreater(seen, 7)
            file.unlink()

    def test_many_states_are_single_ones_on_any_number_of_threads(self):
        bogie = robovec.load(BOGIE)
        given = states(bogie, 33)
        many = bogie(**given, threads=1)
        for threads in [2, 5]:
            other = bogie(**given, threads=threads)
            for name in many:
                np.testing.assert_array_equal(many[name], other[name])
        one = bogie(**{name: array[4] for name, array in given.items()})
        for name in one:
            np.testing.assert_array_equal(one[name], many[name][4])

    def test_an_array_without_states_is_the_same_for_all(self):
        bogie = robovec.load(BOGIE)
        given = states(bogie, 3)
        given["q"] = given["q"][0]
        found = bogie(**given)
        self.assertEqual(found["M"].shape[0], 3)
        np.testing.assert_array_equal(found["M"][0], found["M"][2])


class Transforming(unittest.TestCase):
    def test_passes_keep_the_function(self):
        bogie = robovec.load(BOGIE)
        fast = bogie.run("$cpu", check=True)
        self.assertLess(fast.operations, bogie.run("atomise").operations)
        given = states(bogie, 4)
        before, after = bogie(**given), fast(**given)
        for name in before:
            scale = np.abs(before[name]).max()
            self.assertLess(np.abs(before[name] - after[name]).max(), 1e-12 * scale)

    def test_derivatives_by_pass_and_by_structure_are_those_of_differences(self):
        plain = robovec.load(ARM, "invdyna", numbers=True)
        passed = plain.differentiate("Qq", ["q", "qd"])
        built = robovec.load(ARM, "invdyna_d", numbers=True)
        given = {name: array[0] for name, array in states(plain, 1).items()}
        found, other = passed(**given), built(**given)
        for by, name in [("q", "Qq_q"), ("qd", "Qq_qd")]:
            columns = []
            for joint in range(len(given[by])):
                moved = []
                for step in [1e-6, -1e-6]:
                    near = dict(given)
                    near[by] = given[by] + step * np.eye(len(given[by]))[joint]
                    moved.append(plain(**near)["Qq"])
                columns.append((moved[0] - moved[1]) / 2e-6)
            wanted = np.stack(columns, axis=1)
            scale = np.abs(wanted).max() + 1
            np.testing.assert_allclose(found[name], wanted, atol=1e-7 * scale)
            np.testing.assert_allclose(other[name], found[name], atol=1e-12 * scale)

    def test_a_placed_program_reports_its_schedule(self):
        placed = robovec.load(SUSPENSION).run("$shorten,place")
        report = placed.report()
        self.assertEqual(report["schedule"]["cycles"], 157)
        self.assertEqual(report["operations"], placed.operations)


class Compiling(unittest.TestCase):
    def test_compiled_functions_compute_the_same(self):
        for path, function in [(BOGIE, "dirdyna"), (ARM, "invdyna_d")]:
            program = robovec.load(path, function)
            given = states(program, 19)
            compiled = program.compile(passes="$cpu")
            wanted, found = program(**given), compiled(**given)
            own = compiled.arrays(19)
            for name, array in {**program.parameters(), **given}.items():
                own[name][...] = array
            uncopied = compiled(**own)
            for name in wanted:
                scale = np.abs(wanted[name]).max() + 1e-30
                self.assertLess(np.abs(wanted[name] - found[name]).max(), 1e-11 * scale)
                np.testing.assert_array_equal(found[name], uncopied[name])
            single = compiled(**{name: array[3] for name, array in given.items()})
            for name in single:
                scale = np.abs(wanted[name]).max() + 1e-30
                self.assertLess(np.abs(single[name] - found[name][3]).max(), 1e-12 * scale)


class Documentation(unittest.TestCase):
    def test_the_examples_of_the_pages_run(self):
        before = os.getcwd()
        os.chdir(ROOT)
        try:
            for page in ["README.md", "docs/python.md", "docs/tutorials.md"]:
                text = (ROOT / page).read_text()
                blocks = re.findall(r"```python\n(.*?)```", text, re.S)
                self.assertGreater(len(blocks), 0, page)
                names = {}
                for block in blocks:
                    exec(compile(block, page, "exec"), names)
        finally:
            os.chdir(before)


if __name__ == "__main__":
    unittest.main()
