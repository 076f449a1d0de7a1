"""The package as it was installed, beside the program of the command line."""

import html
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np
import robovec

try:
    import casadi as ca
except ImportError:
    ca = None

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARM = ROOT / "examples/robots/arm.urdf"
QUADRUPED = ROOT / "examples/robots/quadruped.urdf"
FOUR_BAR = ROOT / "examples/robots/four-bar.xml"
BOGIE = ROOT / "examples/models/bogie.mbs"
PROGRAM = os.environ.get("ROBOVEC", str(ROOT / "target/release/robovec"))
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


    def test_what_is_left_out_is_warned_of(self):
        text = ARM.read_text()
        joint = re.search(r'<joint [^>]*type="(?:revolute|continuous)"[^>]*>', text).group()
        with tempfile.TemporaryDirectory() as folder:
            lossy = pathlib.Path(folder) / "lossy.urdf"
            lossy.write_text(text.replace(joint, joint + '<dynamics damping="1"/>', 1))
            with self.assertWarnsRegex(UserWarning, "damping, friction and springs of 1 joint"):
                robovec.load(lossy)

    def test_every_function_is_loaded_by_its_name(self):
        kinds = subprocess.run([PROGRAM, "gen", "--help"], capture_output=True, text=True).stdout
        kinds = re.search(r"of a model: all, ([\w, ]+)\]", kinds).group(1).split(", ")
        self.assertIn("gensensor", kinds)
        for model in [ARM, BOGIE]:
            for kind in kinds:
                text = subprocess.run(
                    [PROGRAM, "gen", str(model), "--function", kind], capture_output=True, text=True
                ).stdout
                names = re.findall(r"^function (\w+) ", text, re.M)
                for name in names[:1] + names[-1:]:
                    self.assertEqual(robovec.load(model, name, numbers=True).name, name)
                if not names:
                    with self.assertRaisesRegex(robovec.Error, "would be empty"):
                        robovec.load(model, kind)


class Names(unittest.TestCase):
    """Names of joints, bodies and frames in place of their numbers."""

    def test_elements_are_given_and_found_by_names(self):
        arm = robovec.load(ARM, "invdyna", numbers=False)
        last = arm.joints[-1]
        self.assertEqual((len(arm.joints), arm.index("q", last)), (7, 6))
        self.assertEqual(arm.labels("Qq"), (arm.joints,))
        self.assertEqual(arm.labels("frc")[0], None)
        self.assertEqual(arm.labels("dpt"), (None, None))
        body = arm.labels("m")[0][2]
        load = {body: [1.0, 2.0, 3.0]}
        found = arm(q={last: 0.3}, qd={}, qdd={}, m={body: 2.0}, frc=load, trq={})
        mass, force = arm.parameters()["m"], np.zeros((3, 7))
        mass[2], force[:, 2] = 2.0, [1, 2, 3]
        zero = np.zeros(7)
        wanted = arm(q=0.3 * np.eye(7)[6], qd=zero, qdd=zero, m=mass, frc=force, trq=0 * force)
        np.testing.assert_array_equal(found["Qq"], wanted["Qq"])
        many = arm(q={last: [0.1, 0.3], arm.joints[0]: 0.0}, qd={}, qdd={}, m={body: 2.0}, frc=load, trq={})
        np.testing.assert_array_equal(many["Qq"][1], wanted["Qq"])

    def test_indices_are_those_of_numpy(self):
        mass = robovec.load(ARM, "dirdyna", numbers=True, forces=False)
        one, two = mass.joints[4], mass.joints[1]
        self.assertEqual(mass.index("M", one, two), (4, 1))
        self.assertEqual(mass.index("M", one), (4, slice(None)))
        hand = robovec.load(ARM, "frame_hand", numbers=True)
        self.assertIn("hand", hand.frames)
        self.assertEqual(hand.index("jacobian", two), (slice(None), 1))
        tau = robovec.load(ARM, "invdyna", numbers=True).differentiate("Qq", "q")
        self.assertEqual(tau.index("Qq_q", two, one), (1, 4))
        self.assertEqual(robovec.load(SUSPENSION).joints, ())

    def test_a_case_is_loaded_by_the_name_of_its_body_joint_or_sensor(self):
        bogie = robovec.load(BOGIE)
        bodies = bogie.labels("m")[0]
        place = next(place for place, body in enumerate(bodies) if body)
        for name in [bodies[place], bogie.joints[place]]:
            found = robovec.load(BOGIE, f"gensensor_{name}").name
            self.assertEqual(found, f"gensensor_{place + 1}")

    def test_the_axes_of_a_free_base_are_named_in_the_order_of_its_velocity(self):
        free = robovec.load(QUADRUPED, "invdyna", floating=True, quaternion=True)
        self.assertEqual(free.labels("qd")[0][3:6], ("base_roll", "base_pitch", "base_yaw"))
        self.assertEqual(free.joints[3:6], ("base_yaw", "base_pitch", "base_roll"))

    def test_wrong_names_are_refused_with_the_right_ones(self):
        arm = robovec.load(ARM, "invdyna", numbers=True, forces=False)
        first = arm.joints[0]
        wrong = [
            (lambda: arm(q={first[:-1] + "x": 1}, qd={}, qdd={}), f"did you mean '{first[:-1]}"),
            (lambda: arm(q={"": 1}, qd={}, qdd={}), "no element ''"),
            (lambda: arm(q={first: [[1.0]]}, qd={}, qdd={}), "same number of states"),
            (lambda: arm(q={first: [1, 2], arm.joints[1]: [1]}, qd={}, qdd={}), "same number"),
            (lambda: arm(q={first: 1j}, qd={}, qdd={}), "complex"),
            (lambda: robovec.load(SUSPENSION)(q={first: 1}), "no names"),
            (lambda: arm.index("q", first, first), "fewer names"),
            (lambda: arm.index("q"), "at least one"),
            (lambda: arm.labels("x"), "no array 'x'"),
            (lambda: robovec.load(ARM, "frame_nowhere"), "frame_hand"),
            (lambda: robovec.load(ARM, "gensensor_nowhere"), "gensensor_7"),
        ]
        for call, words in wrong:
            with self.subTest(words), self.assertRaisesRegex(robovec.Error, words):
                call()


class Viewing(unittest.TestCase):
    def test_a_notebook_shows_the_page_in_a_frame(self):
        with tempfile.TemporaryDirectory() as folder:
            before = os.getcwd()
            os.chdir(folder)
            try:
                shown = robovec.load(ARM, "invdyna", numbers=True).run("$cpu").view("atomise,balance")
                self.assertEqual(os.listdir(folder), [])
            finally:
                os.chdir(before)
        frame = re.fullmatch(r'<iframe srcdoc="([^"]*)"([^>]*)></iframe>', shown._repr_html_())
        self.assertEqual(html.unescape(frame.group(1)), shown.page)
        self.assertIn("allow-scripts", frame.group(2))
        self.assertIn("invdyna through atomise,balance", shown.page)
        self.assertIn("equations of invdyna", shown.page)
        # Equations of a file are shown as robovec's text.
        self.assertIn("balance", robovec.load(SUSPENSION).view("balance").page)
        with self.assertRaisesRegex(robovec.Error, "no-such-pass"):
            robovec.load(ARM).view("no-such-pass")


class Gate(unittest.TestCase):
    """What is refused at the gate is always an Error."""

    TEXT = "// robovec 1\nfunction f equations {\n  in q[1..3]\n  out y\n  y = q[1]\n}\n"

    def test_inputs_that_are_no_real_numbers(self):
        program = robovec.parse(self.TEXT)
        compiled = program.compile()
        wrong = [
            (np.array([1 + 2j, 0, 0]), "complex128"),
            (np.array(["2020-01-01"] * 3, dtype="M8[D]"), "datetime64"),
            (np.array([1, 2, 3], dtype="m8[s]"), "timedelta64"),
            (np.ma.masked_array([1.0, 2.0, 3.0], mask=[True, False, False]), "masked"),
            (["a", "b", "c"], "<U1"),
            ([object(), 1, 2], "object"),
            ([[1], [1, 2], [3]], "no array"),
            (np.array([2**63 + 1, 0, 0], np.uint64), "do not hold"),
            ([2**53 + 1, 0, 0], "do not hold"),
            (np.ones((0, 3)), "no states"),
            (np.ones((2, 3, 4)), "shape"),
        ]
        for call in [program, compiled]:
            for value, word in wrong:
                with self.subTest(word), self.assertRaisesRegex(robovec.Error, word):
                    call(q=value)
            for value in [[True, False, True], np.array([1, 2, 3], np.int8), np.float32([1, 2, 3])]:
                self.assertEqual(call(q=value)["y"], float(value[0]))
            whole = np.ma.masked_array([4.0, 2.0, 3.0], mask=False)
            self.assertEqual(call(q=whole)["y"], 4.0)

    def test_numbers_of_threads_points_and_states_have_limits(self):
        program = robovec.parse(self.TEXT)
        given = np.ones((5, 3))
        for threads in [20000, -1, 1025, 1.5, "2", None, 2**40]:
            with self.assertRaises(robovec.Error):
                program(q=given, threads=threads)
        self.assertEqual(program(q=given, threads=np.int64(2))["y"].shape, (5,))
        for check in [-1, 2**40, "x"]:
            with self.assertRaises(robovec.Error):
                program.run("atomise", check=check)
        compiled = program.compile()
        for states in [-1, 1.5]:
            with self.assertRaises(robovec.Error):
                compiled.arrays(states)
        for word in ["f64", "double ", "long double", "half"]:
            with self.assertRaises(robovec.Error):
                program.compile(number=word)

    def test_out_is_written_only_where_it_may_be(self):
        compiled = robovec.parse(self.TEXT).compile()
        given = np.ones((7, 3))
        out = compiled.results(7)
        out["y"].setflags(write=False)
        own = compiled.arrays(7)
        for wrong in [out, {}, {"y": [0.0] * 7}, compiled.results(6), {"y": np.zeros(7, np.float32)}]:
            with self.assertRaises(robovec.Error):
                compiled(q=given, out=wrong)
        self.assertFalse(out["y"].any())
        shared = {"y": own["q"].base.reshape(-1)[:7]}
        with self.assertRaises(robovec.Error):
            compiled(**own, out=shared)
        self.assertTrue(compiled(q=given, out=compiled.results(7))["y"].all())

    def test_files_of_others_stay(self):
        program = robovec.parse(self.TEXT)
        with tempfile.TemporaryDirectory() as folder:
            program.compile(folder=folder)
            program.compile(folder=folder)
            source = next(pathlib.Path(folder).glob("*.c"))
            source.write_text("int mine;\n")
            with self.assertRaisesRegex(robovec.Error, "did not write it"):
                program.compile(folder=folder)
            self.assertEqual(source.read_text(), "int mine;\n")
            with self.assertRaises(robovec.Error):
                program.compile(folder=source / "below")

    def test_empty_texts_are_refused(self):
        for text in ["", "// robovec 1\n", "// robovec 1\r"]:
            with self.assertRaisesRegex(robovec.Error, "no function"):
                robovec.parse(text)


class Evaluating(unittest.TestCase):
    def test_results_are_those_of_the_command_line_bit_for_bit(self):
        program = PROGRAM
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


@unittest.skipIf(ca is None, "CasADi is not installed")
class Casadi(unittest.TestCase):
    """Functions for CasADi beside the programs they are made of, and beside
    CasADi's own derivatives."""

    @classmethod
    def setUpClass(cls):
        cls.tau = robovec.casadi(ARM, "invdyna", right_angles=0, flags=["-O1"])
        draw = np.random.default_rng(3)
        cls.state = [draw.uniform(-1, 1, 7) for _ in range(3)]

    def test_values_are_those_of_the_program(self):
        program = robovec.load(ARM, "invdyna", numbers=True, forces=False)
        wanted = program(**dict(zip(["q", "qd", "qdd"], self.state)))["Qq"]
        found = np.array(self.tau(*self.state)).ravel()
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * abs(wanted).max())
        self.assertEqual(self.tau.name_in(), ["q", "qd", "qdd"])

    def test_jacobians_are_sparse_and_those_of_the_recursion(self):
        blocks = self.tau.jacobian()(*self.state, ca.DM(7, 1))
        program = robovec.load(ARM, "invdyna_d", numbers=True, forces=False)
        wanted = program(**dict(zip(["q", "qd", "qdd"], self.state)))
        for block, name in zip(blocks, ["Qq_q", "Qq_qd"]):
            np.testing.assert_allclose(np.array(block), wanted[name], rtol=0, atol=1e-11)
        self.assertEqual(blocks[0].nnz(), 42)
        mass = robovec.load(ARM, "dirdyna", numbers=True, forces=False)
        mass = mass(q=self.state[0], qd=self.state[1])["M"]
        np.testing.assert_allclose(np.array(blocks[2]), mass, rtol=0, atol=1e-12)

    def test_loops_and_quaternions_have_the_derivatives_of_differences(self):
        free = dict(floating=True, quaternion=True)
        for path, kind, options in [(FOUR_BAR, "accelred", {}), (QUADRUPED, "invdyna", free)]:
            found = robovec.casadi(path, kind, derivatives="first", flags=["-O0"], **options)
            plain = robovec.load(path, kind, numbers=True, forces=False, **options)
            draw = np.random.default_rng(4)
            given = {name: draw.uniform(-0.3, 0.3, plain.inputs[name]) for name in found.name_in()}
            if "quat" in given:
                given["quat"][3] = 1
                given["quat"] /= np.linalg.norm(given["quat"])
            output = found.name_out()[0]
            value = np.array(found.call(list(given.values()))[0]).ravel()
            np.testing.assert_allclose(value, plain(**given)[output], rtol=0, atol=1e-11)
            blocks = found.jacobian().call([*given.values(), value])
            for name, block in zip(given, blocks):
                steps = 1e-5 * np.eye(len(given[name]))
                moved = [plain(**{**given, name: given[name] + sign * steps})[output] for sign in (1, -1)]
                slope = (moved[0] - moved[1]).T / 2e-5
                scale = 1 + np.abs(slope).max()
                np.testing.assert_allclose(np.array(block), slope, rtol=0, atol=1e-7 * scale, err_msg=name)

    def test_gradients_and_hessians_are_those_of_jacobians(self):
        x = [ca.MX.sym(name, 7) for name in ["q", "qd", "qdd"]]
        weight = np.linspace(-1, 1, 7)
        energy = ca.dot(weight, self.tau(*x))
        gradient = ca.Function("g", x, [ca.gradient(energy, x[0])])
        hessian = ca.Function("h", x, [ca.hessian(energy, x[0])[0]])
        jacobian = np.array(self.tau.jacobian()(*self.state, ca.DM(7, 1))[0])
        found = np.array(gradient(*self.state)).ravel()
        np.testing.assert_allclose(found, jacobian.T @ weight, rtol=0, atol=1e-11)
        step, found = 1e-6, np.array(hessian(*self.state))
        for k in range(7):
            moved = [np.array(gradient(self.state[0] + s * step * np.eye(7)[k], *self.state[1:])) for s in (1, -1)]
            np.testing.assert_allclose(found[:, k], ((moved[0] - moved[1]) / (2 * step)).ravel(), atol=1e-7)

    def test_a_function_of_casadi_is_the_same_and_named_the_same(self):
        x, p = ca.SX.sym("x", 2, 2), ca.SX.sym("p")
        sparse = ca.SX(3, 3)
        sparse[0, 1], sparse[2, 0] = ca.sin(x[0, 1]) ** 2 * p, ca.tan(p) / x[1, 0]
        f = ca.Function("f", [x, p], [sparse, x @ x * ca.sqrt(p) ** 3], ["x", "p"], ["s", "y"])
        fast = robovec.accelerate(f)
        self.assertEqual((fast.name_in(), fast.name_out()), (["x", "p"], ["s", "y"]))
        self.assertEqual(fast.nnz_out(0), 2)
        at = [np.array([[0.3, 0.7], [1.1, 0.4]]), 0.8]
        for found, wanted in zip(fast.call(at), f.call(at)):
            np.testing.assert_allclose(np.array(found), np.array(wanted), rtol=1e-14)
        for found, wanted in zip(fast.jacobian().call(at + [0, 0]), f.jacobian().call(at + [0, 0])):
            np.testing.assert_allclose(np.array(found), np.array(wanted), rtol=1e-13)

    def test_random_functions_have_the_derivatives_of_casadi(self):
        """Inputs and outputs of every shape, empty and unused ones among them."""
        shapes = [(1, 1), (3, 1), (2, 2), (1, 3), (0, 1)]
        operations = [
            lambda a, b: a + b,
            lambda a, b: a - b,
            lambda a, b: a * b,
            lambda a, b: a / (2 + b * b),
            lambda a, b: ca.sin(a) * b,
            lambda a, b: ca.sqrt(1 + a * a) - ca.cos(b),
            lambda a, b: a**3 - 0.5,
        ]

        def drawn(seed):
            draw = np.random.default_rng(seed)
            pick = lambda items: items[draw.integers(len(items))]
            given = [ca.SX.sym(f"x{i}", *pick(shapes)) for i in range(draw.integers(1, 4))]
            pool = [x for part in given if part.numel() for x in ca.vertsplit(ca.vec(part))]
            pool += [ca.SX(0.75), ca.SX(-2)]
            pool += [pick(operations)(pick(pool), pick(pool)) for _ in range(20)]
            made = [ca.SX(*pick(shapes[:4])) for _ in range(2)]
            for part in made:
                for k in range(part.numel()):
                    if draw.uniform() < 0.6:
                        part[k] = pick(pool)
            return ca.Function(f"f{seed}", given, made)

        def results(function):
            x = [ca.MX.sym(f"x{i}", *function.size_in(i)) for i in range(function.n_in())]
            total = sum(ca.sum1(ca.vec(part)) for part in function.call(x))
            own = [part for part in x if part.numel()]
            second = [ca.hessian(total, part)[0] for part in own]
            whole = ca.Function("whole", x, [*function.call(x), *(ca.jacobian(total, part) for part in own), *second])
            draw = np.random.default_rng(1)
            found = whole.call([draw.uniform(-1, 1, part.shape) for part in x])
            return [np.array(ca.densify(part), float) for part in found]

        for seed in range(12):
            function = drawn(seed)
            fast = robovec.accelerate(function, flags=["-O0"])
            self.assertEqual(fast.n_in(), function.n_in())
            for found, wanted in zip(results(fast), results(function)):
                np.testing.assert_allclose(found, wanted, rtol=1e-11, atol=1e-11, err_msg=f"seed {seed}")

    def test_what_is_not_taken_is_named(self):
        x = ca.SX.sym("x", 2)
        wrong = [
            (ca.exp(x), "OP_EXP"),
            (x[0] ** x[1], "OP_POW"),
            (ca.if_else(x[0] > 0, x[1], 1), "OP_"),
            (ca.SX([np.inf, 1]) + x, "inf"),
        ]
        for result, word in wrong:
            with self.subTest(word), self.assertRaisesRegex(robovec.Error, word):
                robovec.accelerate(ca.Function("f", [x], [result]))
        with self.assertRaisesRegex(robovec.Error, "derivatives"):
            robovec.casadi(ARM, derivatives="third")
        with self.assertRaisesRegex(robovec.Error, "name"):
            robovec.casadi(ARM, name="no name")
        with self.assertRaisesRegex(robovec.Error, "no-such-compiler"):
            robovec.casadi(ARM, derivatives="none", compiler="no-such-compiler")

    def test_two_robots_live_side_by_side_with_a_floating_base(self):
        fixed = robovec.casadi(ARM, "accelred", derivatives="first")
        free = robovec.casadi(QUADRUPED, "accelred", derivatives="none", floating=True, name="free")
        self.assertEqual((fixed.size1_in(0), free.size1_in(0)), (7, 18))
        # It falls freely.
        qdd = np.array(free(np.full(18, 0.1), np.zeros(18), np.zeros(18))).ravel()
        np.testing.assert_allclose(qdd, -9.81 * np.eye(18)[2], rtol=0, atol=1e-11)


class Documentation(unittest.TestCase):
    def test_the_examples_of_the_pages_run(self):
        before = os.getcwd()
        os.chdir(ROOT)
        try:
            pages = ["README.md", "docs/python.md", "docs/tutorials.md"]
            for page in pages + (["docs/casadi.md", "docs/robots.md"] if ca else []):
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
