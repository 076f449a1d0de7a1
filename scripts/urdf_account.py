"""Dynamics of a URDF file straight from its numbers, in numpy's longdouble (64
bits of mantissa on x86): every link in the frame of the world, Rodrigues'
rotations, geometric Jacobians. It shares no code with what it judges."""

import xml.etree.ElementTree as ElementTree

import numpy as np

Real = np.longdouble
GRAVITY = np.array([0, 0, -9.81], dtype=float).astype(Real)
FREE = [("x", 0, 0), ("y", 0, 1), ("z", 0, 2), ("yaw", 1, 2), ("pitch", 1, 1), ("roll", 1, 0)]


def numbers(node, key, default):
    text = default if node is None else node.get(key, default)
    return np.array([float(word) for word in text.split()]).astype(Real)


def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def skew(a):
    return np.array([[Real(0), -a[2], a[1]], [a[2], Real(0), -a[0]], [-a[1], a[0], Real(0)]])


def rotation(axis, angle):
    k = skew(axis)
    return np.eye(3, dtype=Real) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def pose(node):
    """Offset and rotation of an `origin`."""
    roll, pitch, yaw = numbers(node, "rpy", "0 0 0")
    x, y, z = np.eye(3, dtype=Real)
    return numbers(node, "xyz", "0 0 0"), rotation(z, yaw) @ rotation(y, pitch) @ rotation(x, roll)


class Frame:
    """Where a frame is in the world and how it moves, accelerations of joints
    apart, and the freedoms that move it: number, direction, point or None."""

    def __init__(self):
        zero = np.zeros(3, dtype=Real)
        self.turn, self.origin = np.eye(3, dtype=Real), zero
        self.spin, self.rate, self.acceleration, self.freedoms = zero, zero, zero, []

    def copy(self):
        frame = Frame()
        frame.__dict__.update(self.__dict__)
        return frame

    def moved(self, offset):
        frame = self.copy()
        frame.origin = self.origin + offset
        swing = cross(self.spin, cross(self.spin, offset))
        frame.acceleration = self.acceleration + cross(self.rate, offset) + swing
        return frame

    def placed(self, node):
        offset, turn = pose(node)
        frame = self.moved(self.turn @ offset)
        frame.turn = self.turn @ turn
        return frame

    def freed(self, number, revolute, axis, q, qd):
        world = self.turn @ axis
        if not revolute:
            frame = self.moved(world * q)
            frame.acceleration = frame.acceleration + 2 * qd * cross(self.spin, world)
            frame.freedoms = self.freedoms + [(number, world, None)]
            return frame
        frame = self.copy()
        frame.turn = self.turn @ rotation(axis, q)
        frame.rate = self.rate + qd * cross(self.spin, world)
        frame.spin = self.spin + qd * world
        frame.freedoms = self.freedoms + [(number, world, self.origin)]
        return frame


class Robot:
    """A file; `names` are the pairs of joint name and place of the freedoms in
    the order of the matrices, `base` is fixed or floating."""

    def __init__(self, path, names, base):
        root = ElementTree.parse(path).getroot()
        self.inertials = {link.get("name"): link.find("inertial") for link in root.findall("link")}
        self.children = {name: [] for name in self.inertials}
        roots = set(self.inertials)
        for joint in root.findall("joint"):
            self.children[joint.find("parent").get("link")].append(joint)
            roots.discard(joint.find("child").get("link"))
        self.root, self.floating = roots.pop(), base == "floating"
        self.numbers = {name: number for number, name in enumerate(names)}

    def frames(self, q, qd):
        """The frame of every link."""
        frame = Frame()
        unit = np.eye(3, dtype=Real)
        if self.floating:
            for place, (_, revolute, axis) in enumerate(FREE):
                at = self.numbers["root_joint", place]
                frame = frame.freed(at, revolute, unit[axis], q[at], qd[at])
        pending = [(self.root, frame)]
        while pending:
            link, frame = pending.pop()
            yield link, frame
            for joint in self.children[link]:
                behind = frame.placed(joint.find("origin"))
                kind = joint.get("type")
                if kind in ["revolute", "continuous", "prismatic"]:
                    axis = numbers(joint.find("axis"), "xyz", "1 0 0")
                    axis = axis / np.sqrt(axis @ axis)
                    at = self.numbers[joint.get("name"), 0]
                    behind = behind.freed(at, kind != "prismatic", axis, q[at], qd[at])
                elif kind != "fixed":
                    raise RuntimeError(f"the account knows no {kind} joint")
                pending.append((joint.find("child").get("link"), behind))

    def dynamics(self, q, qd):
        """Mass matrix and bias."""
        q, qd = q.astype(Real), qd.astype(Real)
        count = len(self.numbers)
        mass, bias = np.zeros((count, count), dtype=Real), np.zeros(count, dtype=Real)
        for link, frame in self.frames(q, qd):
            inertial = self.inertials[link]
            if inertial is None or not frame.freedoms:
                continue
            frame = frame.placed(inertial.find("origin"))
            m = Real(float(inertial.find("mass").get("value")))
            entry = {key: Real(float(text)) for key, text in inertial.find("inertia").items()}
            own = np.array([[entry["i" + "".join(sorted(r + c))] for c in "xyz"] for r in "xyz"])
            inertia = frame.turn @ own @ frame.turn.T
            push = m * (frame.acceleration - GRAVITY)
            twist = inertia @ frame.rate + cross(frame.spin, inertia @ frame.spin)
            places, lines, turns = [], [], []
            for number, axis, point in frame.freedoms:
                places.append(number)
                still = np.zeros(3, dtype=Real)
                lines.append(axis if point is None else cross(axis, frame.origin - point))
                turns.append(still if point is None else axis)
            lines, turns = np.array(lines), np.array(turns)
            bias[places] += lines @ push + turns @ twist
            mass[np.ix_(places, places)] += m * (lines @ lines.T) + turns @ inertia @ turns.T
        return mass, bias


def solved(matrix, right):
    """The solution of a symmetric positive definite system."""
    factor, x = matrix.copy(), right.copy()
    count = len(x)
    for k in range(count):
        below = factor[k + 1 :, k] / factor[k, k]
        factor[k + 1 :, k:] -= np.outer(below, factor[k, k:])
        x[k + 1 :] -= below * x[k]
    for k in reversed(range(count)):
        x[k] = (x[k] - factor[k, k + 1 :] @ x[k + 1 :]) / factor[k, k]
    return x
