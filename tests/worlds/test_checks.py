"""What is wrong with a world is named, with its place."""

import pytest

from worlds.checks import demand_sound, problems
from worlds.input_error import InputError
from worlds.layout import world
from worlds.mission import Goal, Mission, Path, StartRegion
from worlds.obstacles import Box, Disc, Polygon, Prism, Sphere, Union
from worlds.queries.survey import survey_world
from worlds.world import World

BOW = Polygon(points=((0, 0), (4, 4), (4, 0), (0, 4)), name="bow")
BLOCK = Box(low=(4, 4), high=(6, 6))


def flat(*obstacles, edges=("open", "open"), **mission):
    task = Mission(**mission) if mission else None
    return World("yard", (10.0, 10.0), edges, obstacles=tuple(obstacles), mission=task)


def space(*obstacles):
    return World("hall", (10.0,) * 3, ("open",) * 3, obstacles=tuple(obstacles))


SQUARE = ((0, 0), (8, 0), (8, 8), (0, 8))


@pytest.mark.parametrize(
    ("unsound", "feature", "place", "text"),
    [
        (flat(BOW), "'bow'", (2.0, 2.0), "obstacle 'bow' crosses itself at (2, 2)"),
        (
            flat(BLOCK, Polygon(points=((0, 0), (1, 1), (2, 2)))),
            "polygon 2",
            None,
            "obstacle polygon 2 has no area",
        ),
        (
            flat(Polygon(points=SQUARE, holes=(((9, 9), (10, 9), (10, 10)),))),
            "polygon 1",
            (9.0, 9.0),
            "obstacle polygon 1 has a hole outside of it at (9, 9)",
        ),
        (
            flat(Union(parts=(BLOCK, BOW), name="both")),
            "'both'",
            (2.0, 2.0),
            "obstacle 'both' crosses itself at (2, 2)",
        ),
        (
            flat(Sphere(centre=(1, 1, 1), radius=1)),
            "sphere 1",
            (),
            "obstacle sphere 1 has three dimensions, its world has 2",
        ),
        (
            flat(Union(parts=(Prism(points=SQUARE, bottom=0, top=1),))),
            "union 1",
            (),
            "obstacle union 1 has three dimensions, its world has 2",
        ),
        (
            space(Disc(centre=(1, 1), radius=1, bottom=12.0)),
            "disc 1",
            None,
            "obstacle disc 1 has bottom 12 not below its top 10",
        ),
        (
            flat(BLOCK, start=StartRegion(low=(4.5, 4.5), high=(5.5, 5.5))),
            "mission.start",
            (4.5, 4.5),
            "mission.start (4.5, 4.5) to (5.5, 5.5) has no room outside the obstacles",
        ),
        (
            flat(BLOCK, path=Path(waypoints=((1, 1), (5, 5.5)), switch=1)),
            "mission.path.waypoints",
            (5.0, 5.5),
            "mission.path.waypoints[1] = (5, 5.5) is inside an obstacle",
        ),
        (
            flat(edges=("solid", "open"), goal=Goal(route=((11, 3),))),
            "mission.goal.route",
            (11.0, 3.0),
            "mission.goal.route[0] = (11, 3) is beyond a solid edge",
        ),
        (
            flat(goal=Goal(route=((1, 1, 1),))),
            "mission.goal",
            (),
            "mission.goal has 3 coordinates, the world has 2",
        ),
    ],
)
def test_errors(unsound, feature, place, text):
    found = problems(unsound)[0]
    assert (found.feature, found.text, found.severity) == (feature, text, "error")
    assert place is None or found.place == pytest.approx(place)
    with pytest.raises(InputError) as refused:
        demand_sound(unsound)
    assert str(refused.value) == f"{text} ({unsound.name})"


def test_a_leg_through_an_obstacle_is_a_warning():
    crossing = flat(BLOCK, path=Path(waypoints=((1, 5), (9, 5), (9, 9)), switch=1))
    (found,) = problems(crossing)
    assert found.severity == "warning"
    assert found.text == "mission.path from (1, 5) to (9, 5) goes through an obstacle"
    assert 4.0 < found.place[0] < 6.0
    demand_sound(crossing)


def test_the_last_leg_of_a_closed_path_counts():
    points = ((1, 5), (1, 9), (9, 9), (9, 5))
    assert problems(flat(BLOCK, path=Path(waypoints=points, switch=1))) == []
    (found,) = problems(flat(BLOCK, path=Path(waypoints=points, switch=1, closed=True)))
    assert "from (9, 5) to (1, 5)" in found.text


def test_a_sound_world_has_no_problems():
    assert problems(flat(BLOCK, start=StartRegion(low=(3, 3), high=(7, 7)))) == []


def test_a_file_with_an_unsound_obstacle_is_refused(tmp_path):
    path = tmp_path / "yard.toml"
    path.write_text(flat(BOW).to_toml())
    with pytest.raises(InputError, match=r"'bow' crosses itself at \(2, 2\) \(.*yard.toml\)"):
        world(str(path))


def test_an_unsound_world_is_never_surveyed():
    with pytest.raises(InputError, match="'bow' of yard is unsound"):
        survey_world(flat(BOW), 1.0)
