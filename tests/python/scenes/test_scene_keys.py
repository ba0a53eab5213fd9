"""Every key of a scene, in every form, is read and has an effect.

The keys and their forms come from the JSON Schema; a new key without a scene here fails.
"""

import copy
import json
import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import lissom


def without_old_words(schema):
    """The schema without the keys that have a new name."""
    if isinstance(schema, list):
        return [without_old_words(inner) for inner in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        key: without_old_words(inner)
        for key, inner in schema.items()
        if not (isinstance(inner, dict) and inner.get("deprecated"))
    }


SCHEMA = without_old_words(json.loads(lissom.Scene.schema()))

#: A URDF file with limits, and an inertia that no body can have.
WRIST = Path(__file__).parents[2] / "data" / "wrist.urdf"

#: Warnings about missing features do not matter here.
pytestmark = pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")

#: Scenes that together contain every key in every form.
SCENES = {
    "everything": """version = 1
[scene]
name = "Everything"
gravity = [0, 1, -9.81]
[[rod]]
base = { position = [0, 0, 0.2], orientation = [0.6, 0, 0.8, 0] }
tip_force = [0, 0.01, 0]
tip_moment = [0, 0.001, 0]
tip_mass = 0.01
q0 = [0.1, 0.2, 0.1, 0.01, 0.02, 0.03, 0.1, 0.1, 0.2, 0.3, 0.1, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1]
v0 = [0.1, 0.2, 0.1, 0.01, 0.02, 0.03, 0.1, 0.1, 0.2, 0.3, 0.1, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1]
[rod.base_motion]
translation = { mean = [0.1, 0, 0], rate = [0, 0.1, 0], amplitude = [0, 0, 0.01], frequency = 2, phase = 1 }
axis = [0, 0, 1]
angle = { mean = 0.1, rate = 1, amplitude = 0.2, frequency = 3, phase = 0.5 }
[[rod.load]]
force = [0, 0, 0.1]
moment = [0, 0.01, 0]
at = 0.1
frame = "body"
[[rod.load]]
force = { mean = [0.1, 0, 0], rate = [0, 0.1, 0], amplitude = [0, 0, 0.1], frequency = 2, phase = 1 }
moment = { times = [0, 0.5], values = [[0, 0, 0], [0, 0.01, 0]] }
along = [0.1, 0.3]
frame = "world"
[[rod.body]]
mass = 0.1
at = 0.15
centre = [0, 0.01, 0]
inertia = [[1e-5, 0, 0], [0, 2e-5, 0], [0, 0, 2e-5]]
[[rod.support]]
at = 0.2
stiffness = [1, 2, 3]
rotational_stiffness = 0.1
damping = [0.1, 0.2, 0.3]
rotational_damping = 0.01
position = [0.1, 0, 0]
orientation = [0.6, 0, 0.8, 0]
[[rod.support]]
stiffness = 1
rotational_stiffness = [0.1, 0.2, 0.3]
damping = 0.1
rotational_damping = [0.1, 0.2, 0.3]
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
shear_modulus = 1e5
density = 1070
modes = { torsion = 1, bend_y = 3, bend_z = 1, stretch = 1, shear_y = 1, shear_z = 1 }
basis = "chebyshev"
retardation_time = 0.01
reference_strain = [0, 1, 0, 1, 0, 0]
min_bend_radius = 0.05
max_strain = 0.2
max_stress = 1e5
shear_correction = 0.9
nodes = 16
[[rod.segment]]
length = 0.1
radius = [0.01, 0.005]
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { torsion = 1, bend_z = 2, shear_y = 1, shear_z = 1 }
basis = "monomial"
reference_strain = { stations = [0, 0.1], values = [[0, 0, 0, 1, 0, 0], [0, 2, 0, 1, 0, 0]] }
shear_correction = [0.8, 0.9]
[[rod.segment]]
length = 0.1
radius = { stations = [0, 0.05, 0.1], values = [0.01, 0.02, 0.005] }
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { shear_y = 2 }
basis = "piecewise_constant"
shear_correction = "cowper"
[[rod.segment]]
length = 0.1
modes = { bend_y = 2 }
basis = "legendre"
[rod.segment.section]
shape = "given"
stiffness = [1, 2, 3, 1e3, 4e2, 5e2]
mass = 0.1
inertia = [2e-6, 1e-6, 1e-6]
centre = [0, 0.01]
[[rod.segment]]
length = 0.1
modes = { bend_y = 2 }
basis = "hermite"
[rod.segment.section]
shape = "given"
stiffness = [
  [1, 0, 0, 0, 0, 0],
  [0, 2, 0, 0, 0, 0],
  [0, 0, 3, 0, 0, 0],
  [0, 0, 0, 1e3, 0, 0],
  [0, 0, 0, 0, 4e2, 0],
  [0, 0, 0, 0, 0, 5e2],
]
mass = 0.2
inertia = [[2e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]]
centre = [0.01, 0]
[simulation]
t0 = 0.25
t_end = 0.75
method = "newmark"
dt = 1e-3
jac = "central"
rtol = 1e-5
atol = 1e-8
output = { dt = 0.1, quantities = ["velocity", "acceleration", "energy"] }
""",
    "sections in a fluid": """version = 1
[[rod]]
[rod.fluid]
density = 1000
velocity = [0.1, 0, 0.2]
viscous_drag = [0.1, 0.2]
drag_coefficients = [1.1, 0.1]
added_mass_coefficient = 0.9
buoyancy = false
[rod.base_motion]
translation = { times = [0, 0.5, 1, 2], values = [[0, 0, 0], [0, 0, 0.01], [0, 0, 0.02], [0, 0, 0]] }
rotation = { times = [0, 1, 2], values = [[1, 0, 0, 0], [0.8, 0.6, 0, 0], [1, 0, 0, 0]] }
[[rod.segment]]
length = 0.2
section = { shape = "circle", radius = 0.01 }
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[[rod.segment]]
length = 0.2
section = { shape = "hollow_circle", outer = 0.01, inner = [0.005, 0.004] }
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[[rod.segment]]
length = 0.2
section = { shape = "rectangle", width = 0.01, height = { stations = [0, 0.2], values = [0.02, 0.01] } }
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[[rod.segment]]
length = 0.2
section = { shape = "ellipse", semi_axis_y = 0.01, semi_axis_z = [0.02, 0.01] }
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[simulation]
t_end = 2
method = "auto"
rtol = 1e-3
""",
    "sections of tables": """version = 1
[[rod]]
[[rod.segment]]
length = 0.2
modes = { bend_y = 1 }
[rod.segment.section]
shape = "given"
stiffness = { stations = [0, 0.2], values = [[1, 2, 3, 1e3, 4e2, 5e2], [1, 3, 3, 1e3, 4e2, 5e2]] }
mass = { stations = [0, 0.1, 0.2], values = [0.1, 0.2, 0.15] }
inertia = { stations = [0, 0.2], values = [[2e-6, 1e-6, 1e-6], [3e-6, 2e-6, 2e-6]] }
centre = { stations = [0, 0.2], values = [[0, 0.01], [0, 0.02]] }
[[rod.segment]]
length = 0.1
modes = { bend_y = 1 }
[rod.segment.section]
shape = "given"
mass = 0.1
inertia = { stations = [0, 0.1], values = [[[2e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]], [4e-6, 2e-6, 2e-6]] }
[rod.segment.section.stiffness]
stations = [0, 0.1]
values = [
  [[1, 0, 0, 0, 0, 0], [0, 2, 0, 0, 0, 0], [0, 0, 3, 0, 0, 0],
   [0, 0, 0, 1e3, 0, 0], [0, 0, 0, 0, 4e2, 0], [0, 0, 0, 0, 0, 5e2]],
  [1, 3, 3, 1e3, 4e2, 5e2],
]
[simulation]
t_end = 2
""",
    "a robot": """version = 1
[scene]
gravity = [0, 0, -9.81]
[base_motion]
translation = { amplitude = [0, 0, 0.01], frequency = 2 }
[fluid]
density = 1
viscous_drag = [0.1, 0.1]
[[link]]
name = "carriage"
position = [0, 0, 0.1]
orientation = [0.8, 0, 0.6, 0]
q0 = [0.02]
v0 = [0.1]
[link.joint]
type = "prismatic"
axis = [0, 1, 0]
stiffness = 10
rest = 0.01
damping = 0.1
friction = 1e-3
friction_velocity = 1e-2
limits = [-0.01, 0.01]
limit_stiffness = 10
limit_dissipation = 0.1
armature = 0.1
[link.body]
mass = 0.1
centre = [0, 0, 0.01]
inertia = [1e-4, 1e-4, 1e-4]
[[link]]
name = "arm"
parent = "carriage"
[link.joint]
type = "revolute"
axis = [0, 1, 0]
stiffness = 0.1
rest = 0.1
damping = 1e-3
armature = 1e-4
friction = 1e-3
friction_velocity = 1e-2
limits = [-1, 1]
limit_stiffness = 10
limit_dissipation = 0.1
[[link.load]]
force = [0, 0, 0.1]
at = 0.1
[[link.support]]
stiffness = 1
[[link.fixed_body]]
mass = 0.1
at = 0.1
[[link.rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[[link]]
name = "nut"
body = { mass = 0.1 }
[link.joint]
type = "screw"
axis = [1, 0, 0]
lead = 0.02
stiffness = 0.1
rest = 0.1
damping = 1e-3
friction = 1e-3
friction_velocity = 1e-2
limits = [-1, 1]
limit_stiffness = 10
limit_dissipation = 0.1
armature = 1e-4
[[link]]
name = "geared nut"
joint = { type = "screw", axis = [0, 0, 1], lead = 1e-3, mimic = { link = "nut" } }
body = { mass = 0.1 }
[[link]]
name = "driven nut"
joint = { type = "screw", axis = [0, 0, 1], lead = 1e-3, motion = { amplitude = 0.1, frequency = 2 } }
body = { mass = 0.1 }
[[link]]
name = "cross"
parent = "arm"
at = 0.1
joint = { type = "universal", axis1 = [1, 0, 0], axis2 = [0, 1, 0] }
body = { mass = 0.01, centre = [0.01, 0.01, 0.02] }
[[link]]
name = "plate"
parent = "cross"
joint = { type = "planar", normal = [0, 0, 1] }
body = { mass = 0.01, centre = [0.01, 0.01, 0.02], inertia = [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]] }
[[link]]
name = "tube"
joint = { type = "cylindrical", axis = [0, 0, 1] }
body = { mass = 0.01, centre = [0.01, 0.01, 0.02] }
[[link]]
name = "ball"
joint = { type = "spherical" }
body = { mass = 0.01, centre = [0.01, 0.01, 0.02], inertia = [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]] }
[[link]]
name = "bird"
joint = { type = "free" }
body = { mass = 0.01, inertia = [1e-4, 1e-4, 1e-4] }
[[link]]
name = "feather"
parent = "bird"
joint = { type = "weld" }
body = { mass = 0.001 }
[[link]]
name = "crank"
[link.joint]
type = "revolute"
axis = [0, 1, 0]
motion = { mean = 0.1, rate = 1, amplitude = 0.2, frequency = 3, phase = 0.5 }
[link.body]
mass = 0.01
centre = [0.01, 0.01, 0.02]
[[link]]
name = "slider"
joint = { type = "prismatic", axis = [0, 1, 0], motion = { times = [0, 0.5, 1], values = [0, 0.1, 0] } }
body = { mass = 0.01 }
[[link]]
name = "follower"
joint = { type = "prismatic", axis = [0, 1, 0], mimic = { link = "arm", multiplier = 0.1 } }
body = { mass = 0.01 }
[[link]]
name = "geared"
joint = { type = "revolute", axis = [0, 1, 0], mimic = { link = "arm", multiplier = -2, offset = 0.1 } }
body = { mass = 0.01, centre = [0.01, 0.01, 0.02] }
[[link]]
name = "table"
[link.joint]
type = "free"
[link.joint.motion]
translation = { amplitude = [0, 0, 0.01], frequency = 2 }
axis = [0, 0, 1]
angle = { rate = 1 }
[[link]]
name = "wing"
parent = "table"
body = { mass = 0.01 }
[link.joint]
type = "free"
motion = { rotation = { times = [0, 1], values = [[1, 0, 0, 0], [0.8, 0.6, 0, 0]] } }
[simulation]
t_end = 0.1
""",
    "actuators": """version = 1
[[link]]
name = "palm"
joint = { type = "revolute", axis = [0, 1, 0], stiffness = 1 }
body = { mass = 0.1, centre = [0.01, 0.01, 0.02] }
[[link]]
name = "finger"
parent = "palm"
[[link.load]]
force = { input = "push", default = [0, 0.1, 0] }
moment = { input = "turn", default = [0.1, 0, 0] }
[[link.rod.segment]]
length = 0.1
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { torsion = 1, bend_y = 1, bend_z = 1 }
[[link.rod.segment]]
length = 0.1
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { stretch = 1, shear_y = 1, shear_z = 1 }
[[tendon]]
name = "pull"
path = [
  { point = [0, 0.01, 0.1] },
  { link = "palm", point = [0, 0, 0.1] },
  { link = "finger", point = [0, 0, 0.02], at = 0.01 },
  { link = "finger", offset = [0.001, [0.01, 0.005]], along = [0.02, 0.15] },
]
tension = { input = "pull", default = 2 }
friction = 0.1
friction_velocity = 1e-2
[[tendon]]
name = "held"
path = [{ link = "finger", offset = [{ stations = [0, 0.1, 0.2], values = [0.01, 0.005, 0.01] }, 0] }]
length = { mean = 0.15, rate = 0.01, amplitude = 0.02, frequency = 2, phase = 1 }
stiffness = 100
damping = 1
[[tendon]]
name = "sliding"
path = [{ link = "finger", offset = [0, -0.01] }]
tension = 1
friction = 0.2
sliding = 1
[[chamber]]
name = "blow"
path = [{ link = "finger", offset = [0.01, 0] }]
area = 1e-4
pressure = { times = [0, 0.5], values = [1e3, 2e3] }
[[motor]]
joint = "palm"
torque = 0.1
limits = [-1, 0.2]
[[motor]]
joint = "palm.angle"
position = 0.1
gains = [0.3, 0.1]
name = "servo"
[[active_strain]]
link = "finger"
strain = "torsion"
amount = 0.1
[[active_strain]]
link = "finger"
strain = "bend_y"
shape = [1, 2]
amount = 0.1
name = "muscle"
[[active_strain]]
link = "finger"
strain = "bend_z"
shape = { stations = [0, 0.2], values = [1, 2] }
amount = 0.1
[[active_strain]]
link = "finger"
strain = "stretch"
shape = 2
amount = 0.1
[[active_strain]]
link = "finger"
strain = "shear_y"
amount = 0.1
[[active_strain]]
link = "finger"
strain = "shear_z"
amount = 0.1
[simulation]
t_end = 0.1
""",
    "loops": """version = 1
[[link]]
name = "arm"
joint = { type = "revolute", axis = [0, 1, 0] }
q0 = [0.1, 0.2, 0.1, 0.05]
v0 = [0.1, 0.2, 0.1, 0.05]
[[link.rod.segment]]
length = 0.5
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1, bend_z = 1, torsion = 1 }
[[link]]
name = "leg"
parent = "arm"
at = 0.2
joint = { type = "spherical" }
body = { mass = 0.1, centre = [0.01, 0.01, 0.02], inertia = [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]] }
[[link]]
name = "block"
position = [0.3, 0, 0.1]
joint = { type = "free" }
body = { mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }
[[loop]]
name = "ball"
kind = { type = "spherical" }
a = { link = "arm", at = 0.3, position = [0.01, 0.02, 0.03], orientation = [0.8, 0.6, 0, 0] }
b = { link = "block", position = [0, 0.1, 0] }
[[loop]]
kind = { type = "distance", length = 0.3 }
a = { link = "leg", position = [0.01, 0, 0] }
b = { position = [0.1, 0.2, 0.3] }
[[loop]]
name = "gear"
kind = { type = "gear", ratio = -2, offset = 0.1 }
a = "arm.bend_y[0]"
b = "arm.angle"
[[loop]]
name = "slot"
kind = { type = "cylindrical", axis = [1, 0.2, 0.3] }
a = "leg"
b = { position = [0.1, 0, 0.1], orientation = [0.8, 0, 0.6, 0] }
[simulation]
t_end = 0.1
""",
    "loops of other kinds": """version = 1
[[link]]
name = "block"
joint = { type = "free" }
body = { mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }
q0 = [0.1, 0.2, 0.3, 0.1, 0.2, 0.3]
[[link]]
name = "other"
joint = { type = "free" }
body = { mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }
[[loop]]
kind = { type = "weld" }
a = "block"
b = "other"
[[loop]]
name = "hinge"
kind = { type = "revolute", axis = [0, 1, 0.2] }
a = "block"
b = "other"
[[loop]]
name = "rail"
kind = { type = "prismatic", axis = [0.1, 1, 0] }
a = "block"
b = { position = [0.1, 0, 0] }
[[loop]]
name = "cross"
kind = { type = "universal", axis1 = [0, 1, 0], axis2 = [1, 0, 0.3] }
b = "block"
a = "other"
[[loop]]
name = "table"
kind = { type = "planar", normal = [0, 0.1, 1] }
a = "block"
[simulation]
t_end = 0.1
""",
    "contacts": """version = 1
[[link]]
name = "arm"
joint = { type = "revolute", axis = [0, 1, 0] }
q0 = [-0.2, 0.02, 0.03, 0.05]
v0 = [0.1, 0.2, 0.1, 0.05]
[[link.rod.segment]]
length = 0.5
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1, bend_z = 1, torsion = 1 }
[[link]]
name = "block"
position = [0.3, 0, 0.1]
joint = { type = "free" }
body = { mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }
q0 = [0, 0, 3, 0, 0, 0]
[[contact]]
name = "floor"
a = "arm"
b = { kind = "half_space", point = [0.1, 0.1, -0.012], normal = [-0.01, -0.02, 1] }
stiffness = 1e5
dissipation = 0.5
friction = [0.1, 0.2, 0.3]
slip_velocity = 1e-3
patch_radius = 0.01
[[contact]]
a = "arm"
b = { link = "block", radius = 0.3, position = [0, 0.01, 0.02] }
friction = 0.5
static_friction = 0.7
stribeck_velocity = 0.02
[[contact]]
name = "coated"
a = "arm"
b = { kind = "half_space", point = [0, 0, -0.011] }
stiffness = 1e5
friction = { stations = [0, 0.1, 0.5], values = [0.4, 0.3, 0.05] }
[[contact]]
name = "crate"
a = { link = "arm", at = 0.2, radius = 0.05, position = [0.01, 0.02, 0.03] }
friction = [0.6, 0.4]
b = { kind = "box", centre = [0.2, 0, -0.11], half_extents = [0.1, 0.2, 0.1], orientation = [0.6, 0, 0.8, 0] }
stiffness = 1e4
[[contact]]
name = "bar"
a = { link = "block", radius = 0.2 }
b = { kind = "capsule", start = [0.2, -0.1, 0.1], end = [0.4, 0.3, 0.2], radius = 0.1 }
stiffness = 1e4
[[contact]]
name = "stone"
a = { link = "block", radius = 0.2 }
b = { kind = "sphere", centre = [0.1, 0.1, 0.1], radius = 0.3 }
stiffness = 1e4
[[contact]]
name = "hills"
a = { link = "block", radius = 0.2 }
stiffness = 1e4
[contact.b]
kind = "height_field"
heights = [[0.1, 0.2], [0.2, 0.1], [0.1, 0.1]]
spacing = [0.2, 0.3]
corner = [0.1, 0, -0.1]
orientation = [0.8, 0, 0.6, 0]
[[contact]]
name = "plain"
a = { link = "block", radius = 0.2 }
b = { kind = "height_field", heights = [[0.1, 0.2], [0.2, 0.1]], spacing = 0.3 }
stiffness = 1e4
[[contact]]
name = "pipe"
a = { link = "block", radius = 0.2 }
b = { kind = "tube", points = [[-1, 0.55, 0.1], [1, 0.55, 0.1], [2, 1, 0.5]], radius = 0.3, wall = 0.1 }
stiffness = 1e4
[[contact]]
name = "ring"
a = { link = "block", radius = 0.2 }
b = { kind = "tube", points = [[0, 0, 1], [0, 0, 2]], radius = 0.3 }
stiffness = 1e4
[[contact]]
name = "tent"
a = { link = "block", radius = 0.2 }
stiffness = 1e4
[contact.b]
kind = "convex_mesh"
points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.1]]
faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
radius = 0.1
[[contact]]
name = "knot"
a = { link = "block", radius = 0.2 }
stiffness = 1e4
[contact.b]
kind = "mesh"
points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.5]]
faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
cell = 0.1
[[contact]]
name = "cell"
a = { link = "block", radius = 0.2 }
stiffness = 1e4
[contact.b]
kind = "distance_grid"
values = [[[0.1, 0.2], [0.1, -0.1], [0.1, 0.1]], [[0.1, 0.1], [0.1, 0.1], [0.1, 0.3]]]
spacing = [0.2, 0.3, 0.4]
corner = [0.1, 0, 0.1]
orientation = [0.8, 0, 0.6, 0]
[simulation]
t_end = 0.1
""",
    "shapes on links": """version = 1
[[link]]
name = "arm"
joint = { type = "revolute", axis = [0, 1, 0] }
[[link.rod.segment]]
length = 0.5
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[[link]]
name = "block"
position = [0.3, 0, 5]
joint = { type = "free" }
body = { mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }
[[contact]]
a = { kind = "half_space", point = [0, 0, -9], link = "arm", at = 0.1 }
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[[contact]]
a = { kind = "sphere", centre = [0, 0, -9], radius = 0.1, link = "arm", at = 0.2 }
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[[contact]]
a = { kind = "capsule", start = [0, 0, -9], end = [0, 1, -9], radius = 0.1, link = "arm", at = 0.3 }
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[[contact]]
a = { kind = "box", centre = [0, 0, -9], half_extents = [0.1, 0.1, 0.1], link = "arm", at = 0.4 }
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[[contact]]
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[contact.a]
kind = "height_field"
heights = [[0, 0], [0, 0]]
spacing = 1
corner = [0, 0, -9]
link = "arm"
at = 0.1
[[contact]]
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[contact.a]
kind = "convex_mesh"
points = [[0, 0, -9], [1, 0, -9], [0, 1, -9], [0, 0, -8]]
faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
link = "arm"
at = 0.2
[[contact]]
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[contact.a]
kind = "mesh"
points = [[0, 0, -9], [1, 0, -9], [0, 1, -9], [0, 0, -8]]
faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
link = "arm"
at = 0.2
[[contact]]
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[contact.a]
kind = "distance_grid"
values = [[[0.1, 0.2], [0.1, -0.1]], [[0.1, 0.1], [0.1, 0.3]]]
spacing = 0.2
corner = [0, 0, -9]
link = "arm"
at = 0.2
[[contact]]
a = { kind = "tube", points = [[0, 0, -9], [1, 0, -9]], radius = 0.2, link = "arm", at = 0.3 }
b = { link = "block", radius = 0.1 }
stiffness = 1e4
[simulation]
t_end = 0.1
""",
    "an imported wrist": f"""version = 1
[import]
urdf = {json.dumps(str(WRIST))}
floating = true
limit_stiffness = 50
mend_inertia = true
q0 = [0.1, 0.2, 0.3, 0.1, 0.2, 0.3, 0.4]
v0 = [0.2, 0.2, 0.3, 0.1, 0.2, 0.3, 0.4]
[[link]]
name = "ball"
parent = "hand"
body = {{ mass = 0.1 }}
[simulation]
t_end = 0.1
""",
    "a mended wrist": f"""version = 1
[import]
urdf = {json.dumps(str(WRIST))}
floating = false
mend_inertia = true
[simulation]
t_end = 0.1
""",
    "a wrist as it is": f"""version = 1
[import]
urdf = {json.dumps(str(WRIST.with_name("plain_wrist.urdf")))}
mend_inertia = false
[simulation]
t_end = 0.1
""",
    "a turning base": """version = 1
[[rod]]
fluid = { density = 1, buoyancy = true }
base_motion = { axis = [0, 0, 1], angle = { times = [0, 0.5, 1, 2], values = [0, 0.1, 0.3, 0] } }
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 1 }
[simulation]
t_end = 1
method = "auto"
output.quantities = ["shape"]
""",
    "open modes": """version = 1
[[rod]]
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
retardation_time = 0.05
modes = "auto"
[simulation]
t_end = 0.02
method = "auto"
rtol = 0.1
""",
    "a pendulum": """version = 1
[pendulum]
length = 2
mass = 3
stiffness = 40
gravity = 1.6
q0 = [0.1, 0.2]
v0 = [0.3, 0.4]
[simulation]
t_end = 1
method = "radau"
""",
} | {
    f'{key} = "{word}"': f'version = 1\n[pendulum]\n[simulation]\nt_end = 1\n{key} = "{word}"\n'
    for key, word in (
        ("jac", "analytic"),
        ("jac", "forward"),
        ("method", "hht"),
        ("method", "generalised_alpha"),
        ("method", "rk45"),
        ("method", "dop853"),
    )
}
SCENES["quasi-static"] = """
version = 1
[[link]]
name = "door"
joint = { type = "revolute", axis = [0, 1, 0], stiffness = 2, friction = 0.1 }
body = { mass = 1, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }
[simulation]
t_end = 1
method = "quasi_static"
"""
# Motions with corners, bodies in a fluid, and magnets.
SCENES |= {
    name: (Path(__file__).parents[1] / "fuzz" / "corpus" / "scenes" / f"{name}.toml").read_text(
        encoding="utf-8"
    )
    for name in ("hulls", "ramps", "magnets", "magnetic_rod")
}
SCENES |= {
    "a contact of the material": SCENES["contacts"].replace("stiffness = 1e5", 'stiffness = "material"')
}
SCENES |= {
    f"magnets in {name}": SCENES["magnets"].replace("field = [0.01, 0.02, 0.03]", f"field = {field}")
    for name, field in {
        "a swing": "{ mean = [1, 0, 0], rate = [0, 1, 0], amplitude = [0, 0, 1], frequency = 2, phase = 1 }",
        "a ramp": "{ times = [0, 0.1], values = [[0, 0, 0.1], [0, 0.1, 0]] }",
        "a hand": '{ input = "B", default = [0, 0.1, 0.2] }',
    }.items()
}

#: Keys without effect on a scene.
SAME = {
    "everything": {
        "rod[0].load[1].frame",
        "rod[0].segment[3].basis",
        "simulation.method",
    },
    "a mended wrist": {"import.floating"},
    "a wrist as it is": {"import.mend_inertia"},
    "a turning base": {"rod[0].fluid.buoyancy"},
}


#: A file in place of an array, which stands for all arrays of numbers alike: `test_to_scene` has its tests.
IN_FILE = {"$ref": "#/definitions/ArrayInFile"}


def branches(schema):
    """The alternatives that a schema allows, without files."""
    return [branch for branch in schema.get("anyOf", []) if branch != IN_FILE]


def followed(schema, place):
    """The schema to which a reference leads, with its name as the place; of an array or a file the array."""
    if IN_FILE in schema.get("anyOf", []) and len(branches(schema)) == 1:
        (schema,) = branches(schema)
    while "$ref" in schema or "allOf" in schema:
        if "allOf" in schema:
            (schema,) = schema["allOf"]
        else:
            place = schema["$ref"].rsplit("/", 1)[1]
            schema = SCHEMA["definitions"][place]
    return schema, place


def words(schema):
    """The words of an enumeration; none for other schemas."""
    return [*schema.get("enum", []), *(word["const"] for word in schema.get("oneOf", []) if "const" in word)]


def forms(schema, place):
    """Possible contents of a scene at a place: keys, types of values, words. References are not followed."""
    schema, _ = followed(schema, place) if IN_FILE in schema.get("anyOf", []) else (schema, place)
    kinds = [(branch, f"{place} of kind {i}") for i, branch in enumerate(branches(schema))]
    items = [(schema["items"], f"{place}[]")] if schema.get("type") == "array" else []
    keys = [(inner, f"{place}.{key}") for key, inner in schema.get("properties", {}).items()]
    for inner, where in kinds + items + keys:
        yield where
        if not {"$ref", "allOf"} & inner.keys():
            yield from forms(inner, where)
    values = [True, False] if schema.get("type") == "boolean" else words(schema)
    yield from (f"{place} = {value}" for value in values)


def matches(schema, value):
    """Whether a value has the type that a schema describes."""
    schema, _ = followed(schema, "")
    if "anyOf" in schema:
        return any(matches(branch, value) for branch in branches(schema))
    if words(schema):
        return value in words(schema)
    match schema["type"]:
        case "boolean":
            return isinstance(value, bool)
        case "number" | "integer":
            return isinstance(value, int | float) and not isinstance(value, bool)
        case "string":
            return isinstance(value, str)
        case "array":
            least, most = schema.get("minItems", 0), schema.get("maxItems", np.inf)
            is_array = isinstance(value, list) and least <= len(value) <= most
            return is_array and all(matches(schema["items"], item) for item in value)
        case "object":
            keys = schema["properties"]
            if not isinstance(value, dict) or not value.keys() <= keys.keys():
                return False
            return all(
                value.get(key) in words(keys[key])
                for key in ("kind", "type", "shape")
                if words(keys.get(key, {}))
            )
    raise AssertionError(f"no test knows a schema such as {schema}")


def used(schema, value, place):
    """The forms that occur in a value."""
    yield place
    schema, place = followed(schema, place)
    for i, branch in enumerate(branches(schema)):
        if matches(branch, value):
            yield from used(branch, value, f"{place} of kind {i}")
            return
    if isinstance(value, str | bool):
        yield f"{place} = {value}"
    if isinstance(value, list):
        for item in value:
            yield from used(schema["items"], item, f"{place}[]")
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from used(schema["properties"][key], inner, f"{place}.{key}")


def test_the_scenes_have_every_key_in_every_form():
    everything = set(forms(SCHEMA, ""))
    for name in SCHEMA["definitions"].keys() - {"ArrayInFile"}:
        schema = SCHEMA["definitions"][name]
        everything |= set(forms(schema, name))
    assert len(everything) > 200
    found = {form for text in SCENES.values() for form in used(SCHEMA, tomllib.loads(text), "")}
    assert everything - found == set(), "give the scenes above what is new"


@pytest.mark.parametrize("name", SCENES)
def test_every_key_is_read(name):
    assert lissom.Scene.loads(SCENES[name]).model.n > 0


def written(value):
    """A value in TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {written(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    return json.dumps(value) if isinstance(value, str | bool) else repr(value)


def paths(value, place=()):
    """The paths of the keys in a document."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        if isinstance(value, dict):
            yield (*place, key)
        yield from paths(inner, (*place, key))


def without(document, path):
    """The document without one key."""
    rest = copy.deepcopy(document)
    table = rest
    for key in path[:-1]:
        table = table[key]
    del table[path[-1]]
    return "\n".join(f"{key} = {written(value)}" for key, value in rest.items())


def meaning(text):
    """The meaning of a scene, in numbers and words; None if it is invalid."""
    try:
        scene = lissom.Scene.loads(text)
    except lissom.SceneError:
        return None
    model, settings = scene.model, scene.simulation
    rng = np.random.default_rng(0)
    q, v, a = (0.1 * rng.standard_normal(model.n) for _ in range(3))
    old = {"duration", "step", "jacobian", "output_step"}
    options = [getattr(settings, key) for key in dir(settings) if not key.startswith("_") and key not in old]
    numbers = [*scene.q0, *scene.v0]
    times = {"t": 0.13} if isinstance(model, lissom.Robot) else {}
    numbers += [*model.inverse_dynamics(q, v, a, **times), model.energy(q, v, **times).gravitational]
    loops = getattr(model, "loops", ())
    numbers += [*model.loop_gaps(q, **times)] if loops else []
    contacts = getattr(model, "contacts", ())
    numbers += [number for each in contacts for number in model.contact_forces(q, v, name=each.name, **times)]
    actuators = [
        (field.name, getattr(each, field.name))
        for each in getattr(model, "actuators", ())
        for field in fields(each)
        if field.name not in ("path", "shape")
    ]
    names = [each.name for each in (*loops, *contacts)]
    rods = model.links if isinstance(model, lissom.Robot) else [model]
    parts = [
        part for each in rods for part in getattr(each, "segments", None) or getattr(each, "rod", None) or ()
    ]
    names += [str((part.min_bend_radius, part.max_strain, part.max_stress)) for part in parts]
    return scene.name, str(options), str(actuators), names, np.array(numbers).tobytes()


@pytest.mark.parametrize(
    "name",
    [
        "everything",
        "sections in a fluid",
        "actuators",
        "loops",
        "loops of other kinds",
        "contacts",
        "a turning base",
        "a pendulum",
    ],
)
def test_every_key_means_something(name):
    """Without a key, the scene is different or invalid."""
    document = tomllib.loads(SCENES[name])
    whole = meaning("\n".join(f"{key} = {written(value)}" for key, value in document.items()))
    assert whole is not None
    assert whole == meaning(SCENES[name])
    for path in paths(document):
        place = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)[1:]
        differs = meaning(without(document, path)) != whole
        assert differs == (place not in SAME.get(name, ())), place


@pytest.mark.parametrize("size", [3, 400])
@pytest.mark.parametrize(
    "wrong",
    [
        '[[link]]\nname = "z"\nparent = "nobody"\n',
        '[[link]]\nname = "z"\nbody.mass = 1\n'
        'joint = { type = "revolute", axis = [0, 0, 1], mimic.link = "nobody" }\n',
        '[[tendon]]\nname = "t"\npath = [{ link = "nobody", offset = [0, 1] }]\ntension = 1\n',
        '[[motor]]\nname = "m"\njoint = "nobody"\ntorque = 1\n',
    ],
    ids=["parent", "mimic", "tendon", "motor"],
)
def test_messages_do_not_list_all_links_of_large_robots(wrong, size):
    """A message for each wrong name with all names took time and memory with the square of the file."""
    link = '[[link]]\nname = "l{}"\njoint = {{ type = "revolute", axis = [0, 0, 1] }}\nbody.mass = 1\n'
    links = "".join(map(link.format, range(size)))
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(f"version = 1\n{links}{wrong}[simulation]\nt_end = 1\n")
    named = [problem for problem in caught.value.problems if "nobody" in problem.wrong + problem.snippet]
    assert named
    for problem in named:
        assert ("l1" in problem.right) is (size == 3), problem
        assert len(problem.right) < 200


#: A hinged body whose inertia is one of these, and what is refused first.
HINGED = """version = 1
[[link]]
name = "arm"
joint = { type = "revolute", axis = [0, 1, 0] }
body = { mass = 1.0, centre = [0.1, 0, 0], inertia = %s }
[simulation]
t_end = 1
"""


def test_principal_moments_are_the_matrix_with_this_diagonal():
    of_moments = lissom.Scene.loads(HINGED % "[1e-3, 2e-3, 2e-3]").model
    of_rows = lissom.Scene.loads(HINGED % "[[1e-3, 0, 0], [0, 2e-3, 0], [0, 0, 2e-3]]").model
    assert of_moments.links[0].body.inertia.tolist() == np.diag([1e-3, 2e-3, 2e-3]).tolist()
    assert of_moments.mass_matrix([0.3]) == of_rows.mass_matrix([0.3])


@pytest.mark.parametrize(
    ("inertia", "words"),
    [
        ("[1e-3, 2e-3]", "got an array of 2; expected an array of 3 numbers or of 3 rows"),
        ("1e-3", "expected an array of 3 numbers or of 3 rows"),
        ("[1e-3, 1e-3, 9e-3]", "got the principal moments 0.001, 0.001, 0.009"),
        ('[1e-3, "a", 1e-3]', 'inertia[1]: got the text "a"; expected a number'),
    ],
)
def test_a_wrong_inertia_is_the_only_problem_of_its_link(inertia, words):
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(HINGED % inertia)
    (problem,) = caught.value.problems
    assert words in str(problem)
