"""Valid and invalid input for robots and links, with the place of errors."""

import copy
import pickle
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom

HINGE = lissom.Revolute((0, 0, 1))
BODY = lissom.Body(1.0, centre=(1, 0, 0), inertia=(0.1, 0.1, 0.1))
SOFT = lissom.Segment(0.3, 0.02, 1e6, poisson_ratio=0.4, density=1000, modes={"bend_y": 2, "bend_z": 2})


def link(name="a", **changes):
    return lissom.Link(name, **({"body": BODY, "joint": HINGE} | changes))


REFUSED_LINKS = {
    "name: got '', expected a name": lambda: link(""),
    "joint.axis: got .*, expected a direction": lambda: link(joint=lissom.Revolute((0, 0, 0))),
    r"orientation: got a quaternion of norm 2": lambda: link(orientation=(2, 0, 0, 0)),
    r"position\[1\]: got NaN": lambda: link(position=(0, np.nan, 0)),
    "at: got -1, expected an arc length >= 0": lambda: link(at=-1, parent="b"),
    "body: got a body beside a rod": lambda: link(rod=[SOFT]),
    "axis2: got .*parallel to axis1": lambda: lissom.Universal((0, 0, 1), (0, 0, -2)),
    "axis.* zero": lambda: lissom.Revolute((0, 0, 0)),
    "stiffness: got -1": lambda: lissom.Revolute((0, 0, 1), stiffness=-1),
    "limits: got .*the first one the smaller": lambda: lissom.Revolute(
        (0, 0, 1), limits=(1, -1), limit_stiffness=1
    ),
    "limit_stiffness: got 0": lambda: lissom.Prismatic((0, 0, 1), limits=(-1, 1)),
    "limits: got none": lambda: lissom.Prismatic((0, 0, 1), limit_stiffness=1),
}


@pytest.mark.parametrize("message", REFUSED_LINKS)
def test_links_that_make_no_sense_are_refused(message):
    expected = message if message.startswith("joint.axis") is False else "axis: got"
    with pytest.raises(ValueError, match=expected):
        REFUSED_LINKS[message]()


def robot(*links, **others):
    return lissom.Robot(links, **others)


REFUSED_ROBOTS = {
    "links: got none": robot,
    r"links\[0\].parent: got 'b', expected the name of a link that stands before": lambda: robot(
        link(parent="b"), link("b")
    ),
    r'links\[1\].name: got "a", the name of another link': lambda: robot(link(), link()),
    r"links\[0\].at: got 0.1": lambda: robot(link(at=0.1)),
    r'links\[1\].at: got 0.1 on "a", which has no rod': lambda: robot(link(), link("b", parent="a", at=0.1)),
    r"links\[1\].at: got 0.5, expected an arc length in \[0, 0.3\]": lambda: robot(
        link(body=None, rod=[SOFT]), link("b", parent="a", at=0.5)
    ),
    r'links\[0\].joint: got a joint of "a" with no mass behind it': lambda: robot(link(body=None)),
    r"links\[0\].joint: got no inertia against a motion of a.angle": lambda: robot(
        link(body=lissom.Body(1.0, centre=(0, 0, 1)))
    ),
    r"links\[0\].joint: got no inertia against a motion of a.rotation": lambda: robot(
        link(joint=lissom.Spherical(), body=lissom.Body(1.0, centre=(0, 0, -1)))
    ),
    r"links\[1\].joint: got no inertia against a motion of b.angle, a.angle": lambda: robot(
        link(body=None), link("b", parent="a")
    ),
    r"loads\[0\].link: got 'z', expected one of the links: 'a', 'b'": lambda: robot(
        link(), link("b"), loads=[lissom.Load(force=(0, 0, 1), link="z")]
    ),
    r"loads\[0\].link: got none": lambda: robot(link(), link("b"), loads=[lissom.Load(force=(0, 0, 1))]),
    r"loads\[0\].at: got a place on \"a\", which has no rod": lambda: robot(
        link(), loads=[lissom.Load(force=(0, 0, 1), at=0.1)]
    ),
    r"loads\[0\].link: got 'x', expected none": lambda: lissom.Rod(
        [SOFT], loads=[lissom.Load(force=(1, 0, 0), link="x")]
    ),
}


@pytest.mark.parametrize("message", REFUSED_ROBOTS)
def test_robots_that_make_no_sense_are_refused(message):
    with pytest.raises(ValueError, match=message):
        REFUSED_ROBOTS[message]()


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: lissom.Link("a", joint=None),
        lambda: lissom.Link("a", rod=SOFT),
        lambda: lissom.Link("a", body=SOFT),
        lambda: lissom.Link(1),
        lambda: lissom.Revolute("x"),
        lambda: lissom.Revolute((0, 1)),
        lambda: lissom.Revolute((0, 0, 1), stiffness="soft"),
        lambda: lissom.Robot(link()),
        lambda: lissom.Robot([BODY]),
        lissom.Joint,
    ],
)
def test_what_is_of_the_wrong_kind_is_refused(wrong):
    with pytest.raises((TypeError, ValueError)):
        wrong()


def test_what_can_be_read_only_once_is_kept():
    assert lissom.Link("a", rod=(segment for segment in [SOFT])).rod == (SOFT,)


def test_links_and_robots_can_be_copied():
    made = robot(
        link(
            joint=lissom.Revolute(np.array([0, 0, 2.0]), stiffness=1.0, limits=[-1, 1], limit_stiffness=5.0)
        ),
        link("b", parent="a", joint=lissom.Free(), position=[0.1, 0, 0]),
        link("c", parent="b", body=None, rod=[SOFT], joint=lissom.Weld()),
        link("d", parent="c", at=0.1, joint=lissom.Universal((1, 0, 0), (0, 1, 0))),
        loads=[lissom.Load(force=(0, 0, 1), link="c", at=0.2)],
        bodies=[lissom.Body(0.1, link="c")],
        supports=[lissom.Support(stiffness=1.0, link="d")],
    )
    q = np.linspace(0.1, 0.3, made.n)
    for twin in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made), lissom.Robot(made.links)):
        assert twin.links == made.links
        assert twin.coordinates == made.coordinates
    twin = pickle.loads(pickle.dumps(made))
    assert (twin.loads, twin.bodies, twin.supports) == (made.loads, made.bodies, made.supports)
    np.testing.assert_array_equal(twin.inverse_dynamics(q, q, q), made.inverse_dynamics(q, q, q))
    assert made.links[0].joint.axis == (0.0, 0.0, 2.0)


def test_coordinates_have_names_and_links_their_slices():
    made = robot(link(joint=lissom.Free()), link("b", parent="a", body=None, rod=[SOFT, SOFT]))
    assert made.coordinates[:6] == tuple(f"a.{name}" for name in ("x", "y", "z")) + tuple(
        f"a.rotation_{axis}" for axis in "xyz"
    )
    assert made.coordinates[11] == "b.segment[1].bend_y[0]"
    assert made.slice("b") == slice(6, 15, 1)
    with pytest.raises(ValueError, match="link: got 'c', expected one of the links: 'a', 'b'"):
        made.slice("c")


def test_places_on_rigid_links_are_refused():
    made = robot(link())
    with pytest.raises(ValueError, match=r"X: got 0\.1, but link 'a' has no rod"):
        made.pose([0.1], 0.1)


def test_explanations_name_links_and_what_acts_on_joints():
    made = robot(
        link(joint=lissom.Revolute((0, 0, 1), damping=0.1)), link("b", parent="a", joint=lissom.Weld())
    )
    text = made.explain()
    assert "Robot of 2 links with 1 coordinate, planar kernel" in text
    assert "a, revolute joint" in text
    assert "viscous damping" in text
    assert made.kernel == "planar"


def test_explanations_say_which_link_costs_what():
    soft = lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.4, density=1000, modes={"bend_y": 3, "bend_z": 2})
    hinges = [link(f"hinge{i}", joint=lissom.Revolute((0, i, 1))) for i in range(12)]
    made = robot(*hinges[:6], link("finger", body=None, rod=[soft], parent="hinge2"), *hinges[6:])
    lines = made.explain().split("cost of links\n")[1].splitlines()
    assert [line.split()[0] for line in lines[:1] + lines[-1:]] == ["finger", "3"]
    assert lines[0].endswith("6 coordinates, 12 nodes")
    assert lines[-1].split()[:3] == ["3", "other", "links"]
    for what in ("residual", "Jacobian"):
        shares = [float(line.split(f" % of the {what}")[0].split()[-1]) for line in lines]
        assert shares[0] == max(shares)
        assert sum(shares) == pytest.approx(100.0, abs=0.05 * len(shares))
    assert "cost of links" not in robot(hinges[0]).explain()


def test_errors_of_auto_are_those_of_all_links():
    """The base of the last link never moves here, but its bodies do."""
    pendulum = robot(link(), gravity=(0, -9.81, 0))
    run = lissom.simulate(pendulum, 8.0, q0=[np.pi - 1e-3], method="auto", rtol=1e-5)
    exact = lissom.simulate(
        pendulum, 8.0, q0=[np.pi - 1e-3], method="dop853", rtol=1e-12, atol=1e-13, t_eval=run.t
    )
    error = np.abs(run.q - exact.q).max()
    assert run.success
    assert error <= 1e-5
    assert run.stats.time_error >= 0.2 * error
    assert run.stats.space_error is None, "nothing of it is discretised"


def test_places_and_velocities_ask_no_load():
    """A callable load is called only for forces."""

    def fails(t):
        raise AssertionError

    rod = lissom.Rod([SOFT], loads=[lissom.Load(force=fails)])
    q = np.zeros(rod.n)
    rod.pose(q)
    rod.jacobian(q)
    rod.velocity(q, q)
    rod.centre_of_mass(q)
    with pytest.raises(AssertionError):
        rod.base_wrench(q, q, q, t=0.0)


@pytest.mark.parametrize("parent", [lambda i: f"{i - 1}", lambda i: "0"], ids=["chain", "star"])
def test_thousands_of_links_take_time_in_proportion_to_their_number(parent):
    """Names were compared with all others: 20 000 links took 18 s."""
    body = lissom.Body(1.0)

    def seconds(count):
        links = [lissom.Link("0", body=body, joint=lissom.Revolute((0, 1, 0)), position=(0, 0, 0.1))]
        links += [
            lissom.Link(f"{i}", body=body, parent=parent(i), position=(0.01, 0, 0)) for i in range(1, count)
        ]
        begin = time.process_time()
        lissom.Robot(links)
        return time.process_time() - begin

    few = min(seconds(500) for _ in range(3))
    # Eight times as many: 64 times as long in proportion to the square.
    assert seconds(4000) < 24 * few + 0.05


def length_of(robot):
    """What accuracies are relative to, as it is told."""
    (line,) = [line for line in robot.explain().splitlines() if line.strip().startswith("length ")]
    return float(line.split()[1])


@given(st.integers(1, 6), st.floats(1e-3, 1e3))
@settings(max_examples=20, deadline=None)
def test_the_length_of_a_rigid_chain_counts_its_offsets_once(number, metre):
    """Joints a metre apart, centres in the middle: the last centre is half a metre from the last joint."""
    half = lissom.Body(1.0, centre=(0, 0, -0.5 * metre))
    links = [
        lissom.Link(
            f"link {i}",
            parent=f"link {i - 1}" if i else None,
            position=(0, 0, -metre if i else 0.0),
            joint=lissom.Revolute((0, 1, 0)),
            body=half,
        )
        for i in range(number)
    ]
    assert length_of(lissom.Robot(links)) == pytest.approx((number - 0.5) * metre, rel=1e-3)


def test_the_length_of_branches_is_that_of_the_longest_way():
    segment = lissom.Segment(1.0, 0.01, 1e6, 4e5, 1e3, {"bend_y": 2})
    stem = lissom.Link("stem", rod=[segment])
    hand = lissom.Body(0.1, centre=(0.1, 0, 0))
    for at, offset, right in ((0.3, 0.2, 1.0), (0.3, 0.9, 1.3), (None, 0.2, 1.3)):
        joint = lissom.Revolute((0, 1, 0))
        link = lissom.Link("hand", parent="stem", at=at, position=(0, 0, offset), joint=joint, body=hand)
        assert length_of(lissom.Robot([stem, link])) == pytest.approx(right, rel=1e-3)


def test_the_length_begins_where_something_moves():
    """A pedestal of 3 m below the first rod moves nothing."""
    soft = lissom.Segment(0.3, 4e-3, 1e6, poisson_ratio=0.5, density=1000.0, modes={"bend_y": 2})
    stand = lissom.Link("stand", body=lissom.Body(5.0, centre=(0, 0, 1.0)))
    high = lissom.Link("rod", rod=[soft], parent="stand", position=(0, 0, 3.0))
    assert length_of(lissom.Robot([stand, high])) == pytest.approx(0.3, rel=1e-3)
    assert length_of(lissom.Robot([lissom.Link("rod", rod=[soft])])) == pytest.approx(0.3, rel=1e-3)


def test_bodies_of_a_robot_count_like_those_of_links():
    hinge, own = lissom.Revolute((0, 1, 0)), lissom.Body(0.2, centre=(0.25, 0, 0))
    arm = lissom.Link("arm", body=own, joint=hinge)
    far = lissom.Body(1.0, centre=(2.0, 0, 0))
    beside = lissom.Robot([arm], bodies=[lissom.Body(1.0, centre=(2.0, 0, 0), link="arm")])
    welded = lissom.Robot([arm, lissom.Link("far", parent="arm", body=far)])
    assert length_of(beside) == length_of(welded) == 2.0


@given(st.floats(1e-3, 1e3))
@settings(max_examples=10, deadline=None)
def test_point_masses_at_rest_on_springs_are_as_long_as_they_are_apart(metre):
    """Nothing has a size, and nothing goes anywhere."""
    rail = lissom.Prismatic((1, 0, 0), stiffness=10.0)

    def masses(*places):
        links = [
            lissom.Link(f"{i}", joint=rail, body=lissom.Body(1.0), position=place)
            for i, place in enumerate(places)
        ]
        return lissom.Robot(links, gravity=(0, 0, 0))

    assert length_of(masses((0, 0, 0), (3 * metre, 0, 0), (3 * metre, 4 * metre, 0))) == pytest.approx(
        5 * metre, rel=1e-3
    )
    assert length_of(masses((metre, 0, 0))) == 1.0, "nothing tells how long"
