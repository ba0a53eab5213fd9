"""Environments for reinforcement learning: Gymnasium's rules, plausible motions, vector environments."""

import copy
import pickle
import runpy
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils import seeding
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.testing import assert_allclose, assert_array_equal

import lissom
import lissom.gym
from lissom.gym import balance, reach, swim

ROOT = Path(__file__).parents[3]
NAMES = ("Reach", "Balance", "Swim")
IDS = [f"lissom/{name}-v0" for name in NAMES]


@pytest.fixture(params=IDS)
def name(request):
    return request.param


class Overpulled(lissom.gym.Reach):
    """Tendons that make an arm turn by more within four steps than Newton's method can follow."""

    control_step = 0.02

    def inputs(self, actions):
        return 400.0 * (actions + 1.0)


class Turning(lissom.gym.Task):
    """A rod on a rotating base: the position of its tip depends on the time."""

    dt, control_step, max_episode_steps = 5e-3, 0.02, 50
    window = ((-0.5, -0.5, 0.0), (0.5, 0.5, 0.0))

    def __init__(self):
        soft = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_z": 2}, retardation_time=0.05)
        pull = lissom.Tendon("pull", [lissom.Along(offset=(0.008, 0))], tension=lissom.Input("pull"))
        turning = lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(0, 0, rate=3.0))
        self.robot = lissom.Rod([soft], actuators=[pull], base_motion=turning)
        self.channels = dict.fromkeys("xyz", 1.0)

    def start(self, robot, random):
        return lissom.gym.Start(0.1 * random.standard_normal(2), np.zeros(2), np.empty(0))

    def inputs(self, actions):
        return actions + 1.0

    def outcome(self, states):
        tips = states.ask(lambda robot, q, v, t: robot.pose(q, t=t)[:, :3, 3], states.t)
        return lissom.gym.Outcome(tips, tips[:, 0])


class Antagonists(Turning):
    """One action for two tendons."""

    action_names = ("bend",)

    def __init__(self):
        super().__init__()
        pulls = [
            lissom.Tendon(name, [lissom.Along(offset=(y, 0))], tension=lissom.Input(name))
            for name, y in (("left", 0.008), ("right", -0.008))
        ]
        soft = self.robot.segments[0]
        self.robot = lissom.Rod([soft], gravity=(0, 0, 0), actuators=pulls)
        self.channels = {"height": 1.0, "bend": 1.0}

    def inputs(self, actions):
        return 1.0 + 3.0 * np.maximum(np.concatenate([actions, -actions], axis=-1), 0.0)

    def outcome(self, states):
        tips = states.ask(lambda robot, q, v: robot.pose(q)[:, :3, 3])
        return lissom.gym.Outcome(np.column_stack([tips[:, 1], states.actions[:, 0]]), tips[:, 1])


def softer(random):
    """An arm of another material; a module-level function, so that other processes find it by name."""
    return reach.arm(random.uniform(5e5, 9e5), random.uniform(900.0, 1200.0))


def run(env, steps, seed=0):
    """Everything that an environment returns, including resets."""
    given = [env.reset(seed=seed)]
    env.action_space.seed(seed)
    for _ in range(steps):
        given.append(env.step(env.action_space.sample()))
        if given[-1][2] or given[-1][3]:
            given.append(env.reset())
    return given


def assert_same(first, second):
    """Compares bitwise, through dictionaries and sequences."""
    if isinstance(first, dict):
        assert first.keys() == second.keys()
        for key in first:
            assert_same(first[key], second[key])
    elif isinstance(first, tuple | list) or getattr(first, "dtype", float) == "O":
        assert len(first) == len(second)
        for each, other in zip(first, second, strict=True):
            assert_same(each, other)
    else:
        assert_array_equal(first, second, strict=isinstance(first, np.ndarray))


# Gymnasium's rules


def test_the_checker_of_gymnasium_finds_nothing(name):
    # Warnings are errors here.
    check_env(gymnasium.make(name).unwrapped)


def test_the_same_seed_gives_the_same_bits(name):
    first, second, other = (run(gymnasium.make(name), 60, seed) for seed in (5, 5, 6))
    assert_same(first, second)
    assert not np.array_equal(first[-1][0], other[-1][0])


def test_random_actions_give_numbers_within_the_space(name):
    env = gymnasium.make(name)
    given = run(env, 3 * env.spec.max_episode_steps)
    assert sum(len(each) == 2 for each in given) >= 4
    for observation, *rest in given:
        assert observation in env.observation_space
        if len(rest) == 4:
            assert np.isfinite(rest[0])
            assert type(rest[0]) is float
    # Within the bounds, and no channel is constant.
    observations = np.array([each[0] for each in given])
    assert (np.ptp(observations, axis=0) > 0).all()


@pytest.mark.parametrize("way", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_to_the_bit(name, way):
    env = gymnasium.make(name)
    run(env, 30)
    other = way(env)
    for _ in range(40):
        action = env.action_space.sample()
        one, two = env.step(action), other.step(action)
        assert_same(one, two)
        if one[2] or one[3]:
            assert_same(env.reset(), other.reset())


def test_pictures_show_tendons_in_rods():
    """Not only lines: rods are blue, and gold where tendons shine through."""
    env = lissom.gym.RobotEnv("reach", render_mode="rgb_array")
    env.reset(seed=0)
    red, green, blue = np.moveaxis(env.render().astype(int), -1, 0)
    assert np.sum(blue - red > 10) > 100
    # The cross of the goal has no green.
    assert np.sum((red - blue > 10) & (red - green < 40)) > 100


def test_pictures(name):
    env = gymnasium.make(name, render_mode="rgb_array")
    env.reset(seed=0)
    before = env.render()
    assert before.dtype == np.uint8
    assert before.shape == (400, 400, 3)
    for _ in range(30):
        env.step(np.linspace(-1, 1, env.action_space.shape[0]))
    assert (env.render() != before).any()


def test_films_run_in_real_time(name):
    for env in (gymnasium.make(name), gymnasium.make_vec(name, num_envs=2)):
        assert env.metadata["render_fps"] * env.unwrapped.task.control_step == pytest.approx(1.0)


def test_pictures_of_many(name):
    many = gymnasium.make_vec(name, num_envs=2, render_mode="rgb_array")
    alone = SyncVectorEnv([lambda: gymnasium.make(name, render_mode="rgb_array")] * 2)
    for envs in (many, alone):
        envs.reset(seed=0)
        envs.step(np.full(envs.action_space.shape, 0.5))
    assert many.render_mode == alone.render_mode
    assert_same(many.render(), alone.render())
    with pytest.raises(ValueError, match="render_mode: expected None or 'rgb_array', got 'human'"):
        gymnasium.make_vec(name, num_envs=2, render_mode="human")


def test_a_base_may_move():
    task = Turning()
    env = lissom.gym.RobotEnv(task, render_mode="rgb_array")
    many = lissom.gym.RobotVectorEnv(task, 3, max_episode_steps=10, render_mode="rgb_array")
    same = lissom.gym.RobotVectorEnv(task, 3, max_episode_steps=10, randomise=lambda random: Turning().robot)
    seen, _ = env.reset(seed=1)
    rows, _ = many.reset(seed=0)
    others, _ = same.reset(seed=0)
    assert_array_equal(rows[1], seen)
    assert np.abs(seen[1]) < 0.01
    for k in range(14):
        actions = np.full((3, 1), np.cos(k))
        seen, *_ = env.step(actions[1])
        rows, *_ = many.step(actions)
        others, *_ = same.step(actions)
        assert_array_equal(rows, others)
        simulation = env.simulation
        assert_array_equal(seen, task.robot.pose(simulation.q, t=simulation.t)[:3, 3])
        if k < 10:
            assert_array_equal(rows[1], seen)
    # The second episode of the rows started at time zero.
    assert many.simulations.t == pytest.approx(3 * 0.02)
    tip = task.robot.pose(many.simulations.q[1], t=many.simulations.t[1])[:3, 3]
    assert_array_equal(rows[1], tip)
    assert (env.render() != many.render()[1]).any()


def test_bad_input_is_refused():
    env = gymnasium.make("lissom/Reach-v0").unwrapped
    with pytest.raises(gymnasium.error.ResetNeeded, match="call reset first"):
        env.step(np.zeros(6))
    env.reset(seed=0)
    state = env.simulation.q
    with pytest.raises(ValueError, match=r"action: expected shape \(6,\), got \(5,\)"):
        env.step(np.zeros(5))
    with pytest.raises(ValueError, match="action"):
        env.step(np.full(6, np.nan))
    assert_array_equal(env.simulation.q, state)
    with pytest.raises(ValueError, match="task: expected one of reach, balance, swim, got 'fly'"):
        lissom.gym.RobotEnv("fly")
    with pytest.raises(TypeError, match="task: expected a Task or a name, got int"):
        lissom.gym.RobotEnv(3)
    with pytest.raises(ValueError, match="render_mode: expected None or 'rgb_array', got 'human'"):
        lissom.gym.RobotEnv("reach", render_mode="human")
    with pytest.raises(TypeError, match="randomise: expected a Robot, got int"):
        lissom.gym.RobotEnv("reach", randomise=lambda random: 1).reset()
    with pytest.raises(ValueError, match="randomise: expected a robot with the coordinates"):
        lissom.gym.RobotEnv("reach", randomise=lambda random: balance.cart_pole()).reset()


def test_a_task_gives_what_it_says_it_has():
    task = lissom.gym.Balance()
    task.channels = {"cart": 1.0}
    for env in (lissom.gym.RobotEnv(task), lissom.gym.RobotVectorEnv(task, 2)):
        with pytest.raises(
            ValueError, match=r"Balance.outcome: expected observations of shape \(., 1\), got \(., 8\)"
        ):
            env.reset()


def test_robots_and_classes_in_place_of_tasks_say_what_to_write():
    with pytest.raises(
        TypeError, match=r"got Rod; a task has a robot .*`class Mine\(lissom.gym.Task\)` with"
    ):
        lissom.gym.RobotEnv(lissom.gym.Reach().robot)
    with pytest.raises(TypeError, match=r"got the class: write Reach\(\)"):
        lissom.gym.RobotEnv(lissom.gym.Reach)


class Raise(lissom.gym.Task):
    """As the messages say: a motor lifts a link."""

    robot = lissom.Robot(
        [
            lissom.Link(
                "a", joint=lissom.Revolute((0, 1, 0), damping=0.1), body=lissom.Body(1.0, centre=(0.1, 0, 0))
            )
        ],
        actuators=[lissom.Motor("a", torque=lissom.Input("torque"))],
    )
    channels = {"angle": 10.0}  # noqa: RUF012
    dt, control_step, max_episode_steps = 0.01, 0.05, 100

    def start(self, robot, random):
        return lissom.gym.Start(np.zeros(1), np.zeros(1))

    def inputs(self, actions):
        return 2.0 * actions

    def outcome(self, states):
        return lissom.gym.Outcome(states.q, -np.abs(states.q[:, 0]))


def test_a_task_without_a_goal_is_complete():
    for env in (lissom.gym.RobotEnv(Raise()), lissom.gym.RobotVectorEnv(Raise(), 2)):
        env.reset(seed=0)
        observation, *_ = env.step(np.ones(env.action_space.shape))
        assert (np.abs(observation) > 0).all()


def test_tasks_say_what_they_lack():
    class Half(lissom.gym.Task):
        def inputs(self, actions):
            return actions

    with pytest.raises(
        TypeError,
        match=r"Half is a task without `def start\(self, robot, random\): .*`, `def outcome\(self, ",
    ):
        Half()

    class Bare(Raise):
        control_step = property()

    with pytest.raises(TypeError, match=r"Bare: a task needs the attributes control_step \(the duration"):
        lissom.gym.RobotEnv(Bare())


def test_outcomes_are_of_their_class():
    task = lissom.gym.Balance()
    task.outcome = lambda states: 1.0
    with pytest.raises(TypeError, match=r"Balance.outcome: expected a lissom.gym.Outcome\(.*, got float"):
        lissom.gym.RobotEnv(task).reset()


def test_actions_beyond_the_space_count_as_its_ends():
    one, other = (gymnasium.make("lissom/Balance-v0").unwrapped for _ in range(2))
    one.reset(seed=0), other.reset(seed=0)
    assert_same(one.step(np.array([1.0])), other.step(np.array([7.0])))


@pytest.mark.parametrize("many", [False, True])
def test_a_task_has_its_own_number_of_actions(many):
    task = Antagonists()
    env = lissom.gym.RobotVectorEnv(task, 1) if many else lissom.gym.RobotEnv(task)
    if not many:
        check_env(env, skip_render_check=True)
    shape = (1, 1) if many else (1,)
    assert env.action_space.shape == shape
    ends = []
    for action in (1.0, -1.0):
        env.reset(seed=0)
        for _ in range(40):
            observation, *_ = env.step(np.full(shape, action))
        height, bend = observation[0] if many else observation
        assert bend == action
        ends.append(height)
    # Tendons on either side: the tip goes to the one that pulls, as far as to the other.
    assert ends[0] > 0.05
    assert ends[0] == pytest.approx(-ends[1], abs=0.01)
    with pytest.raises(ValueError, match=r"action: expected shape \((1, )?1,?\), got \((1, )?2,?\)"):
        env.step(np.zeros((1, 2) if many else 2))


@pytest.mark.parametrize("many", [False, True])
def test_inputs_of_another_shape_are_refused(many):
    class Wrong(Antagonists):
        def inputs(self, actions):
            return actions

    env = lissom.gym.RobotVectorEnv(Wrong(), 1) if many else lissom.gym.RobotEnv(Wrong())
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"Wrong.inputs: expected shape \(1, 2\), .* got \(1, 1\)"):
        env.step(np.zeros((1, 1) if many else 1))


@pytest.mark.parametrize("names", ["bend", 3, (), ("a", "a"), (1,)])
def test_names_of_actions_are_a_sequence_of_different_ones(names):
    class Misnamed(Antagonists):
        action_names = names

    for make in (lissom.gym.RobotEnv, lambda task: lissom.gym.RobotVectorEnv(task, 2)):
        with pytest.raises(
            (ValueError, TypeError), match=r"Misnamed.action_names: got .* expected a sequence"
        ):
            make(Misnamed())


def test_what_is_missing_is_said():
    code = "import sys; sys.modules['gymnasium'] = None; import lissom; lissom.gym"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "ImportError: lissom.gym takes Gymnasium: pip install 'lissom[gym]'" in run.stderr


# Tasks of the environments


def test_a_regulator_holds_the_pole_for_ten_seconds_and_nothing_does_not():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "cart_pole_lqr.py"))
    gains = example["gains"]()
    runs = []
    for feedback in (gains, 0.0 * gains):
        env = gymnasium.make("lissom/Balance-v0")
        observation, _ = env.reset(seed=0)
        given = [(observation, 0.0, False, False, {})]
        while not (given[-1][2] or given[-1][3]):
            given.append(env.step(-(feedback @ given[-1][0]) / balance.FORCE))
        runs.append((env.unwrapped.simulation.t, *given[-1]))
    held, fallen = runs
    t, observation, reward, terminated, truncated, _ = held
    assert t == pytest.approx(10.0, abs=1e-12)
    assert (terminated, truncated) == (False, True)
    assert np.abs(observation).max() < 1e-3
    assert reward > 0.999
    t, _, reward, terminated, truncated, info = fallen
    assert t < 3.0
    assert (terminated, truncated, reward) == (True, False, 0.0)
    assert info["status"] == "out_of_bounds"
    assert info["message"].startswith("hinge.angle is")


def test_the_cart_pole_is_that_of_the_example():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "cart_pole_lqr.py"))
    state = np.random.default_rng(0).standard_normal((3, 4))
    one, other = (robot.tangent(*state) for robot in (example["robot"], balance.cart_pole()))
    assert_array_equal(np.array(one), np.array(other))
    assert example["LARGEST"] == balance.FORCE


def beat(env, direction):
    """A slow travelling wave of curvature along the body, at one hertz: towards the tail, or the head."""
    places = np.arange(1, swim.MUSCLES + 1) / (swim.MUSCLES + 1)
    env.reset(seed=0)
    robot, simulation = env.unwrapped.robot, env.unwrapped.simulation
    before = robot.centre_of_mass(simulation.q)
    rewards, speeds = [], []
    for k in range(100):
        phase = 2 * np.pi * (direction * places - k * swim.Swim.control_step)
        _, reward, *_, info = env.step(np.sin(phase))
        rewards.append(reward)
        speeds.append(info["speed"])
    return robot.centre_of_mass(simulation.q) - before, np.array(rewards), np.array(speeds)


def test_an_eel_swims_against_the_wave_of_its_body():
    env = gymnasium.make("lissom/Swim-v0")
    ahead, rewards, speeds = beat(env, 1.0)
    back, *_ = beat(env, -1.0)
    assert ahead[0] > 0.4
    assert abs(ahead[1]) < 0.2
    assert back[0] < -0.2
    # The integral of the speed by the trapezoidal rule is the distance, up to the oscillation within steps.
    assert speeds.sum() * swim.Swim.control_step == pytest.approx(ahead[0], rel=0.05)
    assert (rewards < speeds / swim.LENGTH).all()


@pytest.mark.parametrize("seed", range(3))
def test_an_arm_reaches_its_target_with_the_tensions_that_it_is_made_of(seed):
    env = gymnasium.make("lissom/Reach-v0", max_episode_steps=600)
    _, info = env.reset(seed=seed)
    assert info["distance"] > reach.REACHED
    # The first random numbers of the episode.
    tensions = seeding.np_random(seed)[0].uniform(0.0, reach.TENSION, 6)
    action = 2 * tensions / reach.TENSION - 1
    for _ in range(600):
        observation, reward, *_, info = env.step(action)
    assert info["is_success"] is True
    assert info["distance"] < 1e-3
    assert reward == pytest.approx(1.0 - reach.EFFORT * np.mean((tensions / reach.TENSION) ** 2), abs=0.02)
    simulation = env.unwrapped.simulation
    tip = simulation.model.pose(simulation.q)[:3, 3]
    assert_allclose(observation[-6:-3], tip, rtol=0, atol=0)
    assert np.linalg.norm(observation[-3:]) == pytest.approx(info["distance"], rel=1e-12)


@pytest.mark.parametrize(
    ("task", "tolerance"),
    [(lissom.gym.Reach(), 1e-3), (lissom.gym.Balance(), 1e-3), (lissom.gym.Swim(), 3e-3)],
    ids=NAMES,
)
def test_steps_are_small_enough(task, tolerance):
    """Under random actions, tips agree with those of an exact method; metres, after 25 control steps."""
    robot, link = task.robot, task.robot.links[-1].name
    start = task.start(robot, np.random.default_rng(1))
    exact = {"dt": task.dt, "method": "radau", "rtol": 1e-6, "atol": 1e-7}
    runs = [lissom.Simulation(robot, q0=start.q, v0=start.v, **method) for method in (task.method, exact)]
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (25, len(robot.inputs)))
    for inputs in task.inputs(actions):
        for simulation in runs:
            assert simulation.step(inputs, duration=task.control_step) == "finished"
        tips = [robot.pose(simulation.q, link=link)[:3, 3] for simulation in runs]
        assert np.linalg.norm(tips[0] - tips[1]) < tolerance


# Failures


def test_a_step_that_fails_ends_the_episode():
    env = lissom.gym.RobotEnv(Overpulled())
    env.reset(seed=0)
    for _ in range(3):
        *_, info = env.step(-np.ones(6))
        assert "status" not in info
    state = env.simulation.q
    observation, reward, terminated, truncated, info = env.step(np.array([1.0, -1, -1, -1, -1, -1]))
    assert (terminated, truncated, reward) == (True, False, 0.0)
    assert info["status"] == env.simulation.status != "finished"
    assert info["message"] == env.simulation.message
    assert observation in env.observation_space
    # The first of four steps have succeeded.
    assert_array_equal(observation[: len(state)], np.clip(env.simulation.q, -100.0, 100.0))
    assert not np.array_equal(env.simulation.q, state)
    env.reset()
    *_, terminated, _, info = env.step(-np.ones(6))
    assert not terminated


def test_a_row_that_fails_disturbs_no_other():
    task = Overpulled()
    envs = lissom.gym.RobotVectorEnv(task, 4)
    alone = lissom.gym.RobotEnv(task)
    envs.reset(seed=10)
    alone.reset(seed=12)
    actions = -np.ones((4, 6))
    for k in range(6):
        actions[1, 0] = 1.0 if k == 3 else -1.0
        observations, rewards, terminated, truncated, infos = envs.step(actions)
        assert terminated.tolist() == [False, k == 3, False, False]
        assert not truncated.any()
        assert_array_equal(observations[2], alone.step(actions[2])[0])
        assert np.isfinite(observations).all()
        assert np.isfinite(rewards).all()
        if k == 3:
            assert infos["_status"].tolist() == [False, True, False, False]
            assert infos["status"][1] == envs.simulations.status[1]
            assert infos["message"][1] == envs.simulations.message(1)
        else:
            assert "status" not in infos
    # It restarted in between.
    assert envs.simulations.t == pytest.approx(task.control_step * np.array([6, 1, 6, 6]))


# Vector environments


def singles(name, count, steps, mode, **options):
    return SyncVectorEnv(
        [lambda: gymnasium.make(name, max_episode_steps=steps, **options)] * count, autoreset_mode=mode
    )


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_many_robots_are_as_many_single_ones_to_the_bit(name, mode):
    """Including ends of episodes at different times: poles fall, and seeds are set again."""
    count, steps = 5, 37
    many = gymnasium.make_vec(name, num_envs=count, max_episode_steps=steps, autoreset_mode=mode)
    alone = singles(name, count, steps, mode)
    assert many.metadata["autoreset_mode"] is mode
    assert many.observation_space == alone.observation_space
    assert many.action_space == alone.action_space
    many.action_space.seed(0)
    for seed in (3, None, [7, None, 9, None, 1]):
        assert_same(many.reset(seed=seed), alone.reset(seed=seed))
        for _ in range(2 * steps):
            actions = many.action_space.sample()
            assert_same(many.step(actions), alone.step(actions))


def test_rows_tell_their_seeds():
    mode = AutoresetMode.DISABLED
    many = gymnasium.make_vec("lissom/Balance-v0", num_envs=3, autoreset_mode=mode)
    alone = singles("lissom/Balance-v0", 3, 500, mode)
    mask = np.array([True, False, True])
    for options in ({"seed": 4}, {"options": {"reset_mask": mask}, "seed": [7, None, None]}, {}):
        assert_same(many.reset(**options), alone.reset(**options))
        assert many.np_random_seed == alone.np_random_seed
        states = [[each.bit_generator.state for each in envs.np_random] for envs in (many, alone)]
        assert_same(*states)


def test_random_robots_are_their_own_in_each_row():
    many = gymnasium.make_vec("lissom/Reach-v0", num_envs=4, max_episode_steps=9, randomise=softer)
    alone = singles("lissom/Reach-v0", 4, 9, AutoresetMode.NEXT_STEP, randomise=softer)
    for seed in (0, None, 5):
        before = many.robots
        assert_same(many.reset(seed=seed), alone.reset(seed=seed))
        assert (many.robots == before) is (seed is None)
        moduli = [robot.segments[0].young_modulus for robot in many.robots]
        assert len(set(moduli)) == 4
        assert moduli == [env.unwrapped.robot.segments[0].young_modulus for env in alone.envs]
        for _ in range(21):
            actions = many.action_space.sample()
            assert_same(many.step(actions), alone.step(actions))
    with pytest.raises(ValueError, match="made anew where all rows begin"):
        many.reset(seed=3, options={"reset_mask": np.array([True, False, False, False])})


def test_rows_begin_where_a_mask_says_so():
    mode = AutoresetMode.DISABLED
    many = gymnasium.make_vec("lissom/Swim-v0", num_envs=3, max_episode_steps=4, autoreset_mode="Disabled")
    alone = singles("lissom/Swim-v0", 3, 4, mode)
    with pytest.raises(ValueError, match="the first reset is one of all rows"):
        many.reset(options={"reset_mask": np.array([True, False, False])})
    assert_same(many.reset(seed=0), alone.reset(seed=0))
    for k in range(8):
        actions = many.action_space.sample()
        assert_same(many.step(actions), alone.step(actions))
        mask = np.array([k == 3, k in (0, 3, 7), k in (2, 6)])
        if mask.any():
            answers = [envs.reset(options={"reset_mask": mask.copy()}) for envs in (many, alone)]
            assert_same(*answers)
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"rows \[0\] have ended"):
        many.step(actions)


@pytest.mark.parametrize("way", [copy.deepcopy, lambda envs: pickle.loads(pickle.dumps(envs))])
def test_copies_of_many_go_on_to_the_bit(name, way):
    many = gymnasium.make_vec(name, num_envs=3, max_episode_steps=20)
    many.reset(seed=0)
    for _ in range(13):
        many.step(many.action_space.sample())
    other = way(many)
    for _ in range(30):
        actions = many.action_space.sample()
        assert_same(many.step(actions), other.step(actions))


def test_what_was_given_stays_as_it_was():
    many = gymnasium.make_vec("lissom/Balance-v0", num_envs=3, max_episode_steps=3)
    given = [many.reset(seed=0)]
    kept = [copy.deepcopy(given[0])]
    for _ in range(8):
        given.append(many.step(many.action_space.sample()))
        kept.append(copy.deepcopy(given[-1]))
    assert_same(given, kept)


def test_bad_input_of_many_is_refused():
    with pytest.raises(ValueError, match="num_envs: expected one or more, got 0"):
        lissom.gym.RobotVectorEnv("reach", 0)
    with pytest.raises(ValueError, match="max_episode_steps: expected one or more, got 0"):
        lissom.gym.RobotVectorEnv("reach", max_episode_steps=0)
    with pytest.raises(ValueError, match="expected one of NextStep, SameStep, Disabled, got 'Never'"):
        lissom.gym.RobotVectorEnv("reach", autoreset_mode="Never")
    with pytest.raises(TypeError, match="workers: expected a whole number, got float"):
        lissom.gym.RobotVectorEnv("reach", workers=1.5)
    many = lissom.gym.RobotVectorEnv("balance", 3)
    with pytest.raises(gymnasium.error.ResetNeeded, match="call reset first"):
        many.step(np.zeros((3, 1)))
    with pytest.raises(ValueError, match="seed: expected a number or 3 of them, got 2"):
        many.reset(seed=[1, 2])
    with pytest.raises(ValueError, match="expected 3 truth values"):
        many.reset(options={"reset_mask": np.zeros(3, dtype=bool)})
    many.reset(seed=0)
    with pytest.raises(ValueError, match=r"action: expected shape \(3, 1\), got \(3,\)"):
        many.step(np.zeros(3))
    with pytest.raises(ValueError, match="action"):
        many.step(np.full((3, 1), np.inf))
    assert_array_equal(many.simulations.t, 0.0)


class Swing(lissom.gym.Task):
    """A pole on a motor, without a window for pictures."""

    dt, control_step, max_episode_steps = 5e-3, 0.02, 20

    def __init__(self):
        bar = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=(0, 1 / 12, 1 / 12))
        pole = lissom.Link("pole", joint=lissom.Revolute((0, 1, 0)), body=bar)
        motor = lissom.Motor("pole", torque=lissom.Input("torque"))
        self.robot = lissom.Robot([pole], actuators=[motor])
        self.channels = {"angle": 10.0}

    def start(self, robot, random):
        return lissom.gym.Start(np.zeros(1), np.zeros(1), np.empty(0))

    def inputs(self, actions):
        return actions

    def outcome(self, states):
        return lissom.gym.Outcome(states.q, -np.abs(states.q[:, 0]))


def test_pictures_need_no_window():
    """By default they show what the robot can reach."""
    env = lissom.gym.RobotEnv(Swing(), render_mode="rgb_array")
    env.reset(seed=0)
    frame = env.render()
    assert frame.shape == (400, 400, 3)
    assert frame.std() > 1.0


@pytest.mark.parametrize("make", [lissom.gym.RobotEnv, lambda task: lissom.gym.RobotVectorEnv(task, 2)])
def test_a_start_that_is_none_is_named(make):
    class Array(Swing):
        def start(self, robot, random):
            return np.zeros(1)

    with pytest.raises(
        TypeError, match=r"Array.start: expected a lissom.gym.Start\(q, v, goal\), got ndarray"
    ):
        make(Array()).reset(seed=0)
