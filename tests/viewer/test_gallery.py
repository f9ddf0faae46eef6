"""What can be opened: scenes show what they say, come back from text, and let nothing else in."""

from __future__ import annotations

import base64
import io
import re
import shlex
import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy.stats import spearmanr

from agents import individuals
from agents.catalogue import BUILT_IN, MODELS
from agents.flock import Flock
from agents.individuals import as_distribution, lognormal, normal, one_of, uniform
from agents.kinds import Kind, chase, flee
from agents.models.declare import TOPICS
from agents.models.related import related_models
from agents.spec import Spec
from app.cli.options.run_arguments import requested_run
from app.package_files import STATIC
from app.viewer.gallery.lessons.lessons import lesson_names
from app.viewer.gallery.saved_scene import (
    PACKED,
    SavedScene,
    command_line,
    pack_scene,
    python,
    unpack_scene,
)
from app.viewer.gallery.scene_collection import (
    FIRST,
    GROUPS,
    LESSON,
    MODEL,
    MOVES,
    WORLD,
    built_in_scene,
    cards,
    find_scene,
    pictures,
    scene_names,
)
from app.viewer.gallery.scene_steps import SceneStep, step_spec
from app.viewer.run.run_preset import preset_spec
from worlds.input_error import InputError
from worlds.layout import layout_names

SHOWN = (
    # scene, changes, observable, tick, relation, bound
    ("spread", {}, "polarisation", 15, ">", 0.9),
    ("spread", {"p2": 1.0}, "polarisation", 12, "<", 0.85),
    ("order", {"eta": 4.0}, "polarisation", 100, "<", 0.2),
    ("mill", {}, "angular-momentum", 4000, ">", 0.9),
    ("school", {}, "angular-momentum", 1000, ">", 0.5),
    ("school", {"dr_o": 4.0}, "polarisation", 1000, ">", 0.9),
    ("bands", {"eta": 0.6}, "polarisation", 1000, ">", 0.4),
    ("bands", {"eta": 0.65}, "polarisation", 1000, "<", 0.2),
    ("clusters", {}, "largest-group", 4000, ">", 200),
    ("clusters", {"D_r": 1.0}, "largest-group", 4000, "<", 120),
    ("pocket", {}, "goal-distance", 3000, "<", 5.0),
    ("mission", {}, "following", 200, ">", 0.9),
    ("mission", {"p2": 1.0}, "following", 200, "<", 0.6),
    ("cars", {}, "polarisation", 1500, ">", 0.9),
    ("echelons", {}, "energy-saved", 1500, ">", 15.0),
    ("drones", {}, "polarisation", 400, ">", 0.7),
    ("predator", {}, "catches", 1500, ">", 20),
    ("predator", {}, "polarisation", 1500, ">", 0.7),
    ("spins", {}, "polarisation", 400, "<", 0.85),
    ("spins", {"eta": 5.0}, "polarisation", 400, ">", 0.9),
)


def found(*words: str) -> set[str]:
    """Names of the cards that a search shows, as `static/gallery.js` searches."""
    texts = {
        one.name: " ".join((one.title, one.line, one.name, one.group, *one.tags)).lower()
        for one in cards()
    }
    return {name for name, text in texts.items() if all(word in text for word in words)}


@pytest.mark.parametrize(
    ("search", "name"),
    [
        ("phase transition", "model:vicsek1995"),
        ("swarm", "model:couzin"),
        ("starling", "model:topological"),
        ("mips", "model:active-brownian"),
        ("predator", "model:squashing"),
        ("traffic", "model:pedestrian"),
        ("evacuation", "model:pedestrian"),
        ("emergence", "model:reynolds"),
        ("boids", "model:reynolds"),
        ("fish", "school"),
        ("1995", "model:vicsek1995"),
    ],
)
def test_what_people_call_it_finds_it(search, name):
    assert name in found(*search.split())


def test_a_search_for_space_finds_all_that_is_in_space():
    in_space = {MODEL + model.name for model in MODELS.values() if 3 in model.dimensions}
    assert found("3d") >= in_space
    assert "model:boundary-points" not in found("3d")


def test_every_rule_has_a_topic_and_the_page_offers_those_that_there_are():
    for model in MODELS.values():
        assert set(TOPICS) & set(model.rule.tags), model.name
    script = (STATIC / "gallery.js").read_text("utf-8")
    offered = re.search(r"const TOPICS = \[(.*?)\]", script)[1]
    assert tuple(re.findall(r'"(\w+)"', offered)) == TOPICS


@pytest.mark.parametrize(("name", "changes", "measure", "tick", "relation", "bound"), SHOWN)
def test_a_scene_shows_what_it_says(name, changes, measure, tick, relation, bound):
    spec = built_in_scene(name).spec
    flock = Flock(spec.but(parameters={**spec.parameters, **changes}))
    flock.run(tick)
    value = flock.observe(measure)
    assert value > bound if relation == ">" else value < bound, value


def test_the_rule_beside_the_one_that_gets_out_of_the_pocket_is_far_from_the_goal_by_then():
    scene = built_in_scene("pocket")
    flock = Flock(scene.spec.but(model=scene.beside.model))
    flock.run(3000)
    assert flock.observe("goal-distance") > 15.0


def test_who_flees_more_is_caught_less_and_knows_no_order():
    flock = Flock(built_in_scene("predator").spec)
    flock.relate("flock", "predator", flee(2.0, 1.0))
    flock.run(1500)
    assert flock.observe("catches") < 20
    assert flock.observe("polarisation") < 0.7


def test_the_fast_fly_in_front_of_the_slow():
    flock = Flock(built_in_scene("sorted").spec)
    flock.run(1500)
    ahead = (flock.position - flock.position.mean(axis=0)) @ flock.heading.mean(axis=0)
    assert spearmanr(flock.own["s"], ahead).statistic > 0.9


def mean_direction(spec, ticks):
    """Degrees from the x axis to the mean heading over the last 200 of so many ticks."""
    flock = Flock(spec)
    flock.run(ticks - 200)
    return np.mean([flock.run(1) or flock.observe("direction") for _ in range(200)])


@pytest.mark.parametrize("seed", range(1, 5))
def test_a_group_of_two_opinions_goes_between_them_unless_they_are_far_apart(seed):
    spec = built_in_scene("opinions").spec.but(seed=seed)
    assert 20 < mean_direction(spec, 1000) < 60
    together = Flock(spec)
    together.run(1000)
    assert together.observe("largest-group") == 50
    apart = Flock(spec.with_values(parameters={**spec.parameters, "g": 160.0}))
    apart.run(2000)
    is_torn = apart.observe("largest-group") < 40
    largest = apart.heading[apart.group_labels() == 0].mean(axis=0)
    angle = np.degrees(np.arctan2(largest[1], largest[0]))
    assert is_torn or min(abs(angle), abs(angle - 160.0)) < 60.0


def way_of_sheep(spec):
    """How far the sheep's centre comes in a thousand ticks, and how far apart they are then."""
    flock = Flock(spec)
    sheep = flock.rows_of("flock")
    before = flock.position[sheep].mean(axis=0)
    flock.run(1000)
    way = np.linalg.norm(flock.position[sheep].mean(axis=0) - before)
    return way, flock.observe("gyration-radius", kind="flock")


@pytest.mark.parametrize("seed", range(1, 5))
def test_a_dog_that_is_slower_drives_sheep_and_one_that_is_faster_scatters_them(seed):
    spec = built_in_scene("sheep").spec.but(seed=seed)
    assert way_of_sheep(spec)[0] > 70
    assert way_of_sheep(spec)[1] < 10
    assert way_of_sheep(spec.relating("flock", "dog", "ignore"))[0] < 30
    (dog,) = spec.kinds
    assert way_of_sheep(spec.but(kinds=(dog.with_parameters({"s": 1.5}),)))[1] > 15


def test_patches_fly_alike_unless_there_is_too_much_noise():
    def alike(**changes):
        spec = built_in_scene("order").spec
        flock = Flock(spec.but(parameters={**spec.parameters, **changes}))
        flock.run(200)
        _, patch = np.unique((flock.position // 3.0).astype(int), axis=0, return_inverse=True)
        sums = np.array([np.bincount(patch.ravel(), one) for one in flock.heading.T])
        return np.linalg.norm(sums, axis=0).sum() / len(patch)

    assert alike() > 0.7
    assert alike(eta=4.0) < 0.45


def test_people_keep_to_lanes_and_a_hundred_of_them_do_so_less():
    def order(spec):
        flock = Flock(spec)
        flock.run(500)
        found = []
        for _ in range(10):
            flock.run(100)
            found.append(flock.observe("lane-order"))
        return np.mean(found)

    few = built_in_scene("lanes").spec
    assert order(few) > 1.5 * order(few.but(agents=100))


@pytest.mark.parametrize("name", scene_names())
def test_a_built_in_scene_is_the_same_after_any_way_through_text(name):
    scene = built_in_scene(name)
    assert scene.watch
    assert scene.tries
    assert SavedScene.from_toml(scene.to_toml(), "text") == scene
    assert unpack_scene(pack_scene(scene)) == scene
    assert len(pack_scene(scene)) < 1000


def test_a_dozen_scenes_and_the_first_is_the_first():
    assert len(scene_names()) >= 12
    assert scene_names()[0] == FIRST
    assert built_in_scene(FIRST).spec.count > 1000


def test_cards_name_what_is_related_and_only_what_opens():
    made = {card.name: card for card in cards()}
    for card in made.values():
        assert len(card.related) <= 3
        assert card.name not in card.related
        assert len(set(card.related)) == len(card.related)
        for name in card.related:
            assert name in made
    assert made["school"].related[:2] == ("model:couzin", "sheep")
    assert made["model:gregoire-chate"].related[:2] == ("bands", "model:vicsek1995")
    assert made["world:drone-arena"].related == ("model:vasarhelyi",)
    for name in (*scene_names(), *(MODEL + name for name in MODELS)):
        assert made[name].related, name


def test_models_are_related_by_their_papers_rules_and_tags():
    def related(name: str, among=None) -> list[str]:
        found = related_models(MODELS[name], among or BUILT_IN)
        return [model.name for model in found]

    assert related("hwvem-nav")[0] == "hwvem", "one rule"
    assert related("vicsek1995")[0] == "vem", "one paper"
    assert "boundary-points" in related("olfati-saber"), "papers of both"
    assert related("dorsogna") == ["couzin"], "tags that few have"
    assert related("vem", [MODELS["vem"], MODELS["pedestrian"]]) == [], "a topic is not enough"


def test_loops_are_of_pictures_that_there_are_move_and_are_light():
    loops = {name: data for name, data in pictures().items() if name.endswith(f"{MOVES}.webp")}
    assert loops
    for name, data in loops.items():
        assert name.replace(MOVES, "") in pictures()
        assert len(data) <= 60_000, name
        loop = Image.open(io.BytesIO(data))
        assert loop.is_animated
        assert loop.size == (240, 160)
    assert sum(map(len, loops.values())) < 3_000_000


def test_everything_that_is_built_in_has_a_card_with_a_picture_and_opens():
    made = {card.name: card for card in cards()}
    wanted = [*scene_names(), *(MODEL + name for name in MODELS)]
    wanted += [WORLD + name for name in layout_names()]
    wanted += [LESSON + name for name in lesson_names()]
    assert set(wanted) <= set(made)
    for name in wanted:
        card = made[name]
        assert card.group in (*GROUPS, "Worlds")
        assert card.title
        assert card.picture, f"{name} has no picture: python docs/make_gallery.py"
        scene = find_scene(name)
        if name.startswith(WORLD):
            assert scene.spec.world == name.removeprefix(WORLD)


MINE = SavedScene("mine", preset_spec("vem", agents=30), look={"links": True})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title = 3\n[run]\nmodel = 'vem'", "title = 3 is no text"),
        ("title = 'x'", "run is missing"),
        ("[run]\nmodel = 'vem'\nagents = 900000", "agents = 900000 is not allowed"),
        ("[run]\nmodel = 'vem'\nagents = -4", "agents = -4 is not allowed"),
        ("[run]\nmodel = 'vem'\nsize = 1e6", "size = 1e+06 is not allowed"),
        ("[run]\nmodel = 'vem'\nsize = [4.0, 5.0]", "all sides are alike"),
        ("[run]\nmodel = 'mine.py'", "unknown model 'mine.py'"),
        ("[run]\nmodel = 'vem'\nworld = '/etc/passwd'", "unknown world '/etc/passwd'"),
        ("[run]\nmodel = 'vem'\nworld = '../worlds/layouts/wrap.toml'", "unknown world"),
        ("[run]\nmodel = 'vem'\nstart = 'given'", "start = 'given' is not allowed"),
        ("[run]\nmodel = 'vem'\n[run.parameters]\neta = 99.0", "eta = 99"),
        ("[run]\nmodel = 'vem'\n[run.parameters]\nnone = 9.0", "'none'"),
        ("[run]\nmodel = 'vem'\nlayout = 3", "layout = 3 is not a table"),
        ("[run]\nmodel = 'vem'\n[beside]\nmodel = 'vem'\nagents = 4", "unknown key 'agents'"),
        ("[run]\nmodel = 'vem'\n[look]\nlinks = 3", "neither true nor false"),
        ("[run]\nmodel = 'vem'\n[look]\nagent_size = nan", "agent_size = nan is not in"),
        ("[run]\nmodel = 'vem'\n[look]\ncolour = 'red'", "unknown look colour 'red'"),
        ("[run]\nmodel = 'vem'\n[look]\nwater = true", "unknown look 'water'"),
        ("speed = -1\n[run]\nmodel = 'vem'", "speed = -1 is not allowed"),
        ("speed = nan\n[run]\nmodel = 'vem'", "speed = nan is not allowed"),
        ("camera = 'inside'\n[run]\nmodel = 'vem'", "unknown camera 'inside'"),
        ("camera = ['x']\n[run]\nmodel = 'vem'", "unknown camera"),
        ("plots = 'all'\n[run]\nmodel = 'vem'", "plots = 'all' is no list"),
        ("colour = 'x'\n[run]\nmodel = 'vem'", "unknown key 'colour'"),
    ],
)
def test_a_wrong_scene_is_refused_in_one_line(text, words):
    with pytest.raises(InputError) as refused:
        SavedScene.from_toml(text, "here.toml")
    assert words in str(refused.value)
    assert "here.toml" in str(refused.value)
    assert "\n" not in str(refused.value)


def made_of(data: bytes) -> str:
    return PACKED + base64.urlsafe_b64encode(data).decode().rstrip("=")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "z.",
        "z.!!",
        "z.äöü",
        "model:mine.py",
        "model:",
        "world:../x",
        "../../etc/passwd",
        made_of(b"no zlib"),
        made_of(zlib.compress(b"\xff\xfe")),
        made_of(zlib.compress(b"a" * 10**7)),
        made_of(zlib.compress(MINE.to_toml().encode())[:-6]),
        PACKED + "A" * 7000,
    ],
)
def test_what_is_no_scene_is_refused(text):
    with pytest.raises(InputError):
        find_scene(text)


@given(st.text(max_size=60))
def test_no_address_breaks_anything(text):
    for name in (text, PACKED + text):
        with pytest.raises(InputError):
            find_scene(name)


def test_words_on_a_scene_stay_on_a_line_and_are_no_signs_that_steer():
    scene = SavedScene.from_toml('title = "a\\nb\\u0007"\n[run]\nmodel = "vem"', "text")
    assert scene.title == "a b"


def test_the_script_of_a_scene_makes_its_run():
    made = SavedScene(
        "mine", preset_spec("vem", agents=30, seed=5, size=4.0, parameters={"eta": 0.5})
    )
    assert command_line(made) == "flockscope lab vem --agents 30 --seed 5 --size 4 --set eta=0.5"
    given: dict = {}
    exec(python(made), given)
    here = Flock(made.spec)
    here.run(100)
    np.testing.assert_array_equal(given["flock"].position, here.position)


def test_the_words_for_a_world_that_was_changed_ask_for_a_file():
    changed = Flock(Spec("vem", agents=5, seed=1)).world
    scene = SavedScene("mine", preset_spec("vem", world=changed))
    assert "scene.toml" in command_line(scene)
    assert "spec.toml" in python(scene)


# Agents that differ.


def differing_scene(**parameters) -> SavedScene:
    """A scene of few agents that differ."""
    return SavedScene("mine", preset_spec("couzin", agents=6, parameters=parameters))


@pytest.mark.parametrize(
    "value", [normal(3.0, 0.5), lognormal(3.0, 1.0), uniform(2.0, 3.0), one_of(2.0, 3.0)], ids=str
)
def test_what_differs_comes_back_from_a_file_an_address_and_words(value):
    scene = differing_scene(s=value, r_r=2.0)
    own = Flock(scene.spec).own["s"]
    for read in (SavedScene.from_toml(scene.to_toml(), "a file"), unpack_scene(pack_scene(scene))):
        assert read.spec.individuals == {"s": value}
        assert np.array_equal(Flock(read.spec).own["s"], own)
    (said,) = re.findall(r"--set s=(\S+)", command_line(scene))
    assert as_distribution(said) == value
    names = {"Flock": Flock, value.kind: getattr(individuals, value.kind)}
    code = python(scene).removeprefix(f"from flockscope import Flock, {value.kind}\n")
    exec(code.replace("flock.run(100)", ""), names)
    assert np.array_equal(names["flock"].own["s"], own)


def test_numbers_of_each_agent_come_back_and_are_too_many_for_words():
    scene = differing_scene(s=[2.0, 2.5, 3.0, 3.5, 4.0, 4.5])
    read = SavedScene.from_toml(scene.to_toml(), "a file")
    assert Flock(read.spec).own["s"].tolist() == [2.0, 2.5, 3.0, 3.5, 4.0, 4.5]
    assert "numbers one by one" in command_line(scene)
    assert "numbers one by one" in python(scene)


def test_a_scene_keeps_what_differs_beside_and_how_it_is_coloured():
    scene = SavedScene(
        "mine",
        preset_spec("vem", agents=6, parameters={"eta": normal(0.5, 0.1)}),
        beside=Spec("couzin", parameters={"s": normal(3.0, 0.5)}),
        look={"colour": "own eta"},
    )
    read = SavedScene.from_toml(scene.to_toml(), "a file")
    assert read.beside.individuals == {"s": normal(3.0, 0.5)}
    assert read.look == {"colour": "own eta"}


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ("tau = {normal = [0.1, 0.01]}", r"tau cannot differ .* \(it\)"),
        ("s = {gamma = [1, 2]}", r"s: unknown distribution 'gamma'.* \(it\)"),
        ("s = {normal = [1, -2]}", r"s: normal\(1, -2\) .* a standard deviation is >= 0"),
        ("x = {normal = [1, 2]}", "unknown parameter 'x'"),
    ],
)
def test_what_cannot_differ_is_refused_in_one_line(parameters, message):
    with pytest.raises(InputError, match=message) as refusal:
        SavedScene.from_toml(f'[run]\nmodel = "couzin"\n[run.parameters]\n{parameters}\n', "it")
    assert "\n" not in str(refusal.value)


def test_a_step_of_a_lesson_moves_agents_that_differ_and_keeps_their_spread():
    scene = differing_scene(s=normal(3.0, 0.5))
    step = SceneStep(
        say="Faster", controls=["s"], ask="What comes?", choices=["more", "less"], bounds=[0.5],
        measure="polarisation", ticks=10, set={"s": 4.0}, shows="more", why="They go on.",
    )  # fmt: skip
    assert step_spec(scene.spec, step).individuals == {"s": normal(4.0, 0.5)}
    text = replace(scene, steps=(step,)).to_toml()
    assert SavedScene.from_toml(text, "it").steps == (step,)


# Kinds of agents.

SHARK = Kind(
    "shark", 2, parameters={"s": normal(4.0, 0.2), "theta": 60.0}, colour="#b03a2e",
    start=[[0.0, 0.0, 0.0], [5.0, 5.5, 5.0]],
    to={"all": chase(2.0, 10.0, power=2.0, catch=0.3, caught="frozen")},
)  # fmt: skip
WHALE = Kind("whale", 1, to={"shark": "own", "flock": flee(1.5)})


def kinds_scene() -> SavedScene:
    """A scene of three kinds of agents."""
    to = {"shark": flee(3.0, 4.0, first=True)}
    return SavedScene("mine", preset_spec("couzin", agents=6, kinds=[SHARK, WHALE], to=to))


def test_kinds_come_back_from_a_file_an_address_and_words():
    scene = kinds_scene()
    first = Flock(scene.spec)
    for read in (SavedScene.from_toml(scene.to_toml(), "a file"), unpack_scene(pack_scene(scene))):
        assert (read.spec.kinds, read.spec.to) == (scene.spec.kinds, scene.spec.to)
        assert np.array_equal(Flock(read.spec).position, first.position)
    words = shlex.split(command_line(scene))
    told = {name: [words[k + 1] for k, word in enumerate(words) if word == f"--{name}"]
            for name in ("kind", "relation", "agents", "seed")}  # fmt: skip
    options = {"kind": told["kind"], "relation": told["relation"]}
    given = {"agents": int(told["agents"][0]), "seed": int(told["seed"][0])}
    again, _ = requested_run("couzin", options | given, [])
    script: dict[str, object] = {}
    exec(python(scene).replace("flock.run(100)", ""), script)
    for flock in (Flock(again), script["flock"]):
        assert flock.kinds.relations == first.kinds.relations
        assert np.array_equal(flock.position, first.position)
        assert np.array_equal(flock.own["s"], first.own["s"])


def test_a_model_of_a_kinds_own_comes_back_from_a_file_an_address_and_words():
    robot = Kind("robot", 2, model="leadership", parameters={"tau": 0.1, "s": normal(2.0, 0.1)})
    spec = preset_spec("couzin", agents=6, dim=2, kinds=[robot])
    scene = SavedScene("mine", spec, look={"colour": "own omega"})
    for read in (SavedScene.from_toml(scene.to_toml(), "a file"), unpack_scene(pack_scene(scene))):
        assert read.spec.kinds == (robot,)
        assert read.look == scene.look
    words = shlex.split(command_line(scene))
    assert words[words.index("--kind") + 1].startswith("robot=2,model=leadership,tau=0.1,")
    script: dict[str, object] = {}
    exec(python(scene).replace("flock.run(100)", ""), script)
    assert script["flock"].kinds.kinds == (robot,)


def test_a_scene_without_kinds_says_nothing_of_them():
    scene = SavedScene("mine", preset_spec("vem", agents=6))
    assert "kinds" not in scene.to_toml()
    assert "kind" not in command_line(scene) + python(scene)
    assert SavedScene.from_toml(scene.to_toml(), "a file").spec.kinds == ()


@pytest.mark.parametrize(
    ("kinds", "message"),
    [
        ("kinds = 3", r"kinds = 3 is not allowed: a list of kinds is needed \(it\)"),
        ("kinds = [{name = 'a', parameters = {v0 = 99.0}}]", r"kind a: v0 = 99\.0 .*\(it\)"),
        ("kinds = [{name = 'a', to = {b = {flee = 1}}}]", r"unknown kind 'b' .*\(it\)"),
        ("kinds = [{name = 'a', agents = 200000}]", "with 200000 of kinds is not allowed"),
        ("kinds = [{name = 'a'}]\nparameters = {neighbours = 'nearest'}", "neighbours=metric"),
        ("kinds = [{name = 'a', model = 'couzin'}]", "its unit of time is s, and that of vem"),
    ],
)
def test_kinds_that_cannot_be_are_refused_in_one_line(kinds, message):
    with pytest.raises(InputError, match=message) as refusal:
        SavedScene.from_toml(f'[run]\nmodel = "vem"\n{kinds}\n', "it")
    assert "\n" not in str(refusal.value)
