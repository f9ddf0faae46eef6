"""`flockscope world`: lists, pictures, checks, drawings read, worlds made."""

import json
import runpy
from pathlib import Path

import pytest
from PIL import Image

from cli.calling import call, refusal
from worlds.layout import layout_names, world

DOCS = Path(__file__).parents[2] / "docs"
HALL = {
    "type": "FeatureCollection",
    "features": [
        {
            "type": "Feature",
            "properties": {"kind": "walkable"},
            "geometry": {
                "type": "Polygon",
                "coordinates": [[[0, 0], [20, 0], [20, 8], [9, 8], [9, 12], [0, 12], [0, 0]]],
            },
        },
        {
            "type": "Feature",
            "properties": {"kind": "pillar", "name": "pillar", "radius": 0.75},
            "geometry": {"type": "Point", "coordinates": [5, 4]},
        },
    ],
}


@pytest.fixture
def hall(tmp_path):
    path = tmp_path / "hall.geojson"
    path.write_text(json.dumps(HALL))
    return path


def made(*args):
    result = call("world", *args)
    assert result.exit_code == 0, result.stderr
    return result


def test_list_names_the_built_in_worlds():
    rows = json.loads(made("list", "--json").stdout)
    assert [row["name"] for row in rows] == layout_names()
    wrap = next(row for row in rows if row["name"] == "wrap")
    assert (wrap["size"], wrap["edges"], wrap["obstacles"], wrap["mission"]) == (
        None,
        "wrap",
        0,
        [],
    )
    shown = made("list").stdout
    assert all(row["name"] in shown for row in rows)


@pytest.mark.parametrize("name", layout_names())
def test_every_built_in_world_is_sound_and_can_be_drawn(tmp_path, name):
    assert json.loads(made("check", name, "--json").stdout)["sound"] is True
    picture = tmp_path / f"{name}.png"
    assert made("show", name, "--out", picture).stderr == f"written: {picture}\n"
    with Image.open(picture) as image:
        assert min(image.size) > 300
        assert len(image.convert("RGB").getcolors(1 << 24)) > 10


def test_a_world_with_random_obstacles_is_drawn_from_a_seed(tmp_path):
    (row,) = [r for r in json.loads(made("list", "--json").stdout) if r["random"]]
    assert row["name"] == "thesis-blocks"
    assert row["random"]["count"] == 20
    free = {
        json.loads(made("check", "thesis-blocks", "--json", *seed).stdout)["holds"]["free"]
        for seed in ((), ("--seed", 0), ("--seed", 1))
    }
    assert len(free) == 2
    pictures = [tmp_path / f"{seed}.png" for seed in (1, 1, 2)]
    for seed, path in zip((1, 1, 2), pictures, strict=True):
        made("show", "thesis-blocks", "--seed", seed, "--out", path, "--overwrite")
    assert pictures[0].read_bytes() == pictures[1].read_bytes() != pictures[2].read_bytes()
    assert "--seed -1 is not allowed" in refusal("world", "check", "thesis-blocks", "--seed", -1)


def test_import_makes_a_layout_that_is_read_as_it_was_drawn(hall, tmp_path):
    layout = tmp_path / "hall.toml"
    result = made("import", hall, "--out", layout, "--json")
    value = json.loads(result.stdout)
    assert value.pop("free_area") == pytest.approx(196 - 3.1416 * 0.75**2, abs=1e-2)
    assert value == {
        "layout": str(layout), "obstacles": 2, "size": [20.0, 12.0], "low": [0.0, 0.0], "notes": [],
        "layers": [
            {"layer": "walkable", "entities": "1 Polygon", "role": "walkable",
             "why": "its name says 'walkable'"},
            {"layer": "pillar", "entities": "1 Point", "role": "obstacle",
             "why": "its name says 'pillar'"},
        ],
    }  # fmt: skip
    found = world(str(layout))
    assert found.edges == ("solid", "solid")
    assert [one.name for one in found.obstacles] == ["pillar", "outside 1"]
    assert found.obstacles[0].radius == 0.75
    assert found.source == "hall.geojson"
    holds = json.loads(made("check", layout, "--json").stdout)["holds"]
    assert holds["obstacles"] == 2
    assert holds["outline_edges"] == 128 + 4
    assert holds["free"] == pytest.approx(1.0 - (44 + 3.1416 * 0.75**2) / 240, abs=1e-4)
    (line,) = made("check", layout).stdout.splitlines()
    assert line.startswith(f"{layout} is sound: 20 x 12 m, 2 obstacles, 132 outline edges, ")


def test_import_takes_its_options(hall, tmp_path):
    layout = tmp_path / "hall.toml"
    args = ("import", hall, "--out", layout, "--scale", 2, "--walkable", "pillar")
    made(*args, "--obstacle", "walkable", "--edges", "open,solid")
    found = world(str(layout))
    assert found.size == (3.0, 3.0)
    assert found.low == (8.5, 6.5)
    assert found.edges == ("open", "solid")
    drawn = tmp_path / "drawn.wkt"
    drawn.write_text("# a room\nwall: LINESTRING (2 2, 6 2)\n")
    options = ("--thickness", 1, "--margin", 1, "--to-origin", "--edges", "wrap", "--overwrite")
    made("import", drawn, "--out", layout, *options)
    found = world(str(layout))
    assert (found.low, found.size, found.edges) == ((0.0, 0.0), (6.0, 3.0), ("wrap", "wrap"))
    assert (found.obstacles[0].start, found.obstacles[0].end) == ((1.0, 1.5), (5.0, 1.5))


def test_what_is_left_out_of_a_drawing_is_told(tmp_path):
    import ezdxf

    document = ezdxf.new(units=6)
    document.modelspace().add_circle((0, 0), 1)
    document.modelspace().add_text("Hall")
    document.saveas(tmp_path / "hall.dxf")
    args = ("import", tmp_path / "hall.dxf", "--out", tmp_path / "hall.toml", "--overwrite",
            "--solid", "0")  # fmt: skip
    assert "hall.dxf: 1 TEXT on layer '0' left out\n" in made(*args).stderr
    assert made(*args, "--quiet").stderr == ""
    assert json.loads(made(*args, "--json").stdout)["notes"] == ["1 TEXT on layer '0' left out"]


@pytest.mark.parametrize("kind", ["discs", "blocks", "forest", "corridors", "maze"])
def test_make_repeats_itself_and_is_sound(tmp_path, kind):
    one, again, other = (tmp_path / f"{k}.toml" for k in range(3))
    value = json.loads(made("make", kind, "--seed", 7, "--out", one, "--json").stdout)
    assert value["size"] == [60.0, 40.0]
    assert value["obstacles"] == len(world(str(one)).obstacles) > 0
    made("make", kind, "--seed", 7, "--out", again)
    made("make", kind, "--seed", 8, "--out", other)
    assert one.read_text() == again.read_text() != other.read_text()
    assert f"generator {kind}: seed 7" in world(str(one)).source


def test_make_takes_its_options(tmp_path):
    path = tmp_path / "balls.toml"
    args = ("make", "discs", "--size", "30,20,10", "--edges", "open,solid,solid", "--out", path)
    result = made(*args, "--set", "count=5", "--set", "gap=0.5")
    assert result.stdout == "5 obstacles in 30 x 20 x 10 m\n"
    assert result.stderr == f"written: {path}\n"
    again = (*args, "--set", "count=1", "--set", "gap=0.5", "--overwrite")
    assert made(*again).stdout == "1 obstacle in 30 x 20 x 10 m\n"
    found = world(str(path))
    assert (found.dim, found.edges) == (3, ("open", "solid", "solid"))


def test_show_draws_points_space_and_svg(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made("make", "maze", "--out", "maze.toml", "--size", "20")
    assert made("show", "maze.toml").stderr == "written: maze.png\n"
    made("show", "maze.toml", "--points", "--out", "points.png")
    assert (tmp_path / "maze.png").read_bytes() != (tmp_path / "points.png").read_bytes()
    value = json.loads(made("show", "maze.toml", "--dim", 3, "--out", "up.svg", "--json").stdout)
    assert value == {"picture": "up.svg"}
    text = (tmp_path / "up.svg").read_text()
    assert text.startswith("<?xml")
    assert "top of a solid" in text
    made("show", "maze.toml", "--dim", 3, "--out", "again.svg")
    assert (tmp_path / "again.svg").read_text() == text


def test_check_prints_every_problem_and_is_exit_code_2(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(
        'size = [10.0, 10.0]\nedges = "solid"\n'
        '[[obstacle]]\nshape = "polygon"\nname = "bow"\n'
        "points = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 3.0]]\n"
        '[[obstacle]]\nshape = "sphere"\nname = "ball"\ncentre = [5.0, 5.0, 1.0]\nradius = 1.0\n'
    )
    result = call("world", "check", path)
    assert result.exit_code == 2
    first, second = result.stdout.splitlines()
    assert first == "error: obstacle 'bow' crosses itself at (1.2, 1.2)"
    assert second == "error: obstacle 'ball' has three dimensions, its world has 2"
    result = call("world", "check", path, "--json")
    assert result.exit_code == 2
    value = json.loads(result.stdout)
    assert (value["sound"], value["holds"]) == (False, None)
    assert value["problems"][0]["place"] == [1.2, 1.2]
    assert [one["severity"] for one in value["problems"]] == ["error", "error"]
    assert "'bow' crosses itself" in refusal("world", "show", path, "--out", tmp_path / "bad.png")


def test_a_warning_is_told_and_is_exit_code_0(tmp_path):
    path = tmp_path / "through.toml"
    path.write_text(
        "size = [10.0, 10.0]\n"
        '[[obstacle]]\nshape = "disc"\ncentre = [5.0, 5.0]\nradius = 1.0\n'
        "[mission.path]\nwaypoints = [[1.0, 5.0], [9.0, 5.0]]\nswitch = 0.3\n"
    )
    warning, sound = made("check", path).stdout.splitlines()
    assert warning.startswith("warning: mission.path from (1, 5) to (9, 5)")
    assert "is sound" in sound


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["show", "wrp"], ["unknown world 'wrp'", "did you mean 'wrap'?"]),
        (["show", "wrap", "--out", "a.pdf"], ["--out 'a.pdf'", ".png or .svg"]),
        (["show", "wrap", "--out", "no/a.png"], ["'no/a.png'", "there is no folder 'no'"]),
        (["show", "wrap", "--size", "wide"], ["--size 'wide'"]),
        (["show", "wrap", "--dim", "3", "--points"], ["--points is not allowed in space"]),
        (["check", "no.toml"], ["'no.toml' cannot be read: No such file"]),
        (["import", "no.dxf", "--out", "x.toml"], ["'no.dxf' cannot be read: No such file"]),
        (["import", "hall.geojson", "--out", "no/x.toml"], ["--out 'no/x.toml' cannot be written"]),
        (["import", "hall.geojson", "--out", "x.toml", "--obstacle", "piller"],
         ["unknown layer 'piller'", "'pillar'", "hall.geojson"]),
        (["import", "hall.geojson", "--out", "x.toml", "--edges", "sold"],
         ["unknown edge 'sold'", "'solid'"]),
        (["import", "hall.geojson", "--out", "x.toml", "--edges", ""], ["edges = []", "2"]),
        (["make", "mase", "--out", "x.toml"], ["unknown kind of world 'mase'", "'maze'"]),
        (["make", "maze", "--out", "x.toml", "--seed", "-1"], ["--seed -1", ">= 0"]),
        (["make", "maze", "--out", "x.toml", "--size", "x"], ["--size 'x'", "number"]),
        (["make", "maze", "--out", "x.toml", "--set", "cel=1"],
         ["unknown parameter of maze 'cel'", "'cell'", "--set"]),
        (["make", "maze", "--out", "x.toml", "--set", "cell"], ["--set cell", "NAME=VALUE"]),
        (["make", "discs", "--out", "x.toml", "--set", "count=900"], ["count = 900", "do not fit"]),
        (["make", "maze", "--out", "x.toml", "--dim", "3"], ["dim = 3", "2-D"]),
        (["make", "maze", "--out", "x.toml", "--edges", "wrap,solid,solid"], ["names 3 axes"]),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_refused_in_one_line(hall, monkeypatch, args, words):
    monkeypatch.chdir(hall.parent)
    line = refusal("world", *args)
    for word in words:
        assert word in line
    assert [path.name for path in hall.parent.iterdir()] == ["hall.geojson"]


def test_no_file_is_replaced_unless_asked(hall, tmp_path):
    for args, name in (
        (("show", "wrap"), "a.png"),
        (("import", hall), "a.toml"),
        (("make", "maze"), "b.toml"),
    ):
        path = tmp_path / name
        path.write_text("mine")
        assert "exists already" in refusal("world", *args, "--out", path)
        assert path.read_text() == "mine"
        made(*args, "--out", path, "--overwrite")
        assert path.stat().st_size > 100


def test_the_pages_of_worlds_have_the_tables_and_pictures_that_are_declared():
    script = runpy.run_path(str(DOCS / "make_worlds.py"))
    pages = {page.name: page.read_text(encoding="utf-8") for page in DOCS.glob("worlds*.md")}
    assert set(script["GENERATED"]) < set(pages)
    for name in script["GENERATED"]:
        assert script["page"](name) == pages[name], "run `uv run python docs/make_worlds.py`"
    for line in "".join(pages.values()).splitlines():
        for piece in line.split("](pictures/")[1:]:
            assert (DOCS / "pictures" / piece.partition(")")[0]).is_file()


def test_the_examples_of_the_pages_do_what_they_say(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script = runpy.run_path(str(DOCS / "make_worlds.py"))
    code, read_page = script["code"], script["read_page"]
    worlds, drawings = read_page("worlds.md"), read_page("worlds-from-drawings.md")
    Path("yard.toml").write_text(code(worlds, "toml"))
    assert f"    {made('check', 'yard.toml').stdout}" in worlds
    Path("hall.geojson").write_text(code(drawings, "json"))
    Path("hall.wkt").write_text(code(read_page("worlds-drawing-formats.md"), "wkt"))
    exec(code(worlds, "python"))
    exec(code(drawings, "python"))
    assert len(world("hall.toml").obstacles) == 3
    made("import", "hall.wkt", "--out", "again.toml")
    names = [one.name for one in world("again.toml").obstacles]
    assert names == ["kiosk", "obstacle", "outside 1"]


def test_a_floor_plan_comes_in_and_is_lived_in(tmp_path):
    plan = tmp_path / "room.wkt"
    plan.write_text(
        "GEOMETRYCOLLECTION (POLYGON ((0 0, 20 0, 20 9, 10 9, 10 14, 0 14, 0 0),"
        " (4 4, 7 4, 7 6, 4 6, 4 4)))\n"
    )
    layout = tmp_path / "room.toml"
    result = made("import", plan, "--out", layout)
    header, row, written = result.stderr.splitlines()
    assert header.split() == ["layer", "entities", "role", "why"]
    assert row.split()[:4] == ["unnamed", "1", "GEOMETRYCOLLECTION", "walkable"]
    assert result.stdout == "2 obstacles in 20 x 14 m, 224 m² free\n"
    assert written == f"written: {layout}"
    made("show", layout, "--out", tmp_path / "room.png")
    run = call("run", "boundary-points", "--world", layout, "--agents", 12, "--ticks", 20, "--json")
    assert run.exit_code == 0, run.stderr
    assert json.loads(run.stdout)["observables"]["inside-obstacles"] == 0


def test_every_problem_of_a_drawing_is_a_line_and_nothing_is_written(tmp_path):
    plan = tmp_path / "room.wkt"
    plan.write_text("stage: POLYGON ((0 0, 4 0, 4 4, 0 0))\nwall: LINESTRING (0 0, 5 0)\n")
    result = call("world", "import", plan, "--out", tmp_path / "room.toml")
    assert result.exit_code == 2
    assert result.stdout == ""
    *table, stage, wall = result.stderr.splitlines()
    assert [line.split()[0] for line in table] == ["layer", "stage", "wall"]
    assert "layer 'stage': no clear role" in stage
    assert "line 2 'wall': an open line from (0, 0) to (5, 0)" in wall
    assert [one.name for one in tmp_path.iterdir()] == ["room.wkt"]
