"""Occupancy grids of ROS: a YAML file and the image that it names, or both in one ZIP file.

The layers are `map` (the box around what is known), `occupied` and `unknown`. A cell is a square
of `resolution`; `origin` is the lower left corner of the map and its turn.

Source: ROS, map_server, and Nav2, nav2_map_server (the modes trinary, scale and raw).
"""

from __future__ import annotations

import io
import math
import warnings
import zipfile
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import shapely
import yaml
from PIL import Image, UnidentifiedImageError

from worlds.input_error import InputError, unknown
from worlds.readers.drawing_contents import LARGEST, DrawingContents, Item, bytes_of, text_of
from worlds.readers.drawn_shapes import Shape, area, at
from worlds.readers.grid import RasterGrid, cells, demand_few_cells, rings
from worlds.readers.roles import OBSTACLE, WALKABLE

LARGEST_YAML = 100_000
"""Bytes of the YAML file at most."""
MODES = ("trinary", "scale", "raw")
NEEDED = ("image", "resolution", "origin")
THRESHOLDS = {"occupied_thresh": 0.65, "free_thresh": 0.25}
"""Those of Nav2, where the file does not say."""
MAP, OCCUPIED, UNKNOWN = "map", "occupied", "unknown"
ROLES = {
    MAP: (WALKABLE, "the box around what is known"),
    OCCUPIED: (OBSTACLE, "the map says so"),
    UNKNOWN: (OBSTACLE, "nobody has seen it free; --ignore unknown opens it"),
}


def read_ros_map(path: Path) -> DrawingContents:
    """The map of a YAML file and its image. Raises InputError."""
    values = settings(text_of(path), str(path))
    image = path.parent / str(values["image"])
    try:
        data = bytes_of(image)
    except InputError as refusal:
        raise InputError(f"{path}, image: {refusal}") from None
    return contents(path, values, data, image.name)


def read_zipped_map(path: Path) -> DrawingContents:
    """The map of a ZIP file that holds one YAML file and its image. Raises InputError."""
    try:
        with zipfile.ZipFile(io.BytesIO(bytes_of(path))) as archive:
            names = [name for name in archive.namelist() if not name.startswith("__MACOSX")]
            found = [name for name in names if name.lower().endswith((".yaml", ".yml"))]
            if len(found) != 1:
                raise InputError(
                    f"{path} holds {len(found)} YAML files: one, and the image that it "
                    "names, are a map of ROS"
                )
            text = member(archive, found[0], LARGEST_YAML, path).decode("utf-8", "replace")
            values = settings(text, f"{path}, {found[0]}")
            wanted = PurePosixPath(str(values["image"])).name
            images = [name for name in names if PurePosixPath(name).name == wanted]
            if not images:
                raise InputError(f"{path} does not hold the image {wanted!r} that {found[0]} names")
            data = member(archive, images[0], LARGEST, path)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        raise InputError(f"{path} is not a ZIP file that can be read: {error}") from None
    return contents(path, values, data, wanted)


def member(archive: zipfile.ZipFile, name: str, most: int, path: Path) -> bytes:
    """A file in a ZIP file, of a bounded size, whatever its header says. Raises InputError."""
    with archive.open(name) as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise InputError(f"{path}, {name}: it has more than {most} bytes")
    return data


class PlainLoader(yaml.SafeLoader):
    """The safe loader without aliases.

    Some hundred bytes of them stand for billions of values, which a message would write.
    """

    def compose_node(self, *where: Any) -> Any:
        """A node of the document. Raises YAMLError for an alias."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("it has aliases (*name), which no map of ROS needs")
        return super().compose_node(*where)


def settings(text: str, origin: str) -> dict[str, Any]:
    """The keys of the YAML file, checked. Raises InputError."""
    if len(text) > LARGEST_YAML:
        raise InputError(f"{origin}: it has more than {LARGEST_YAML} letters, too many for a map")
    try:
        values = yaml.load(text, Loader=PlainLoader)
    except RecursionError:
        raise InputError(f"{origin} is not YAML: it is nested too deep") from None
    except (yaml.YAMLError, ValueError) as error:
        raise InputError(f"{origin} is not YAML: {' '.join(str(error).split())[:200]}") from None
    if not isinstance(values, dict):
        raise InputError(f"{origin} is not a map of ROS: it has no keys")
    missing = [key for key in NEEDED if key not in values]
    if missing:
        raise InputError(f"{origin} is not a map of ROS: it has no {' and no '.join(missing)}")
    if not isinstance(values["image"], str) or not values["image"].strip("/"):
        raise InputError(f"{origin}: image = {values['image']!r:.60} is no name of a file")
    made: dict[str, Any] = {"image": values["image"]}
    made["resolution"] = number(values["resolution"], "resolution", origin)
    if made["resolution"] <= 0.0:
        raise InputError(f"{origin}: resolution = {made['resolution']:g} is not a length > 0")
    pose = values["origin"]
    if not isinstance(pose, list) or len(pose) != 3:
        raise InputError(f"{origin}: origin = {pose!r:.60} is not [x, y, yaw]")
    made["origin"] = [number(value, "origin", origin) for value in pose]
    for key, usual in THRESHOLDS.items():
        made[key] = number(values.get(key, usual), key, origin)
    if not 0.0 <= made["free_thresh"] <= made["occupied_thresh"] <= 1.0:
        low, high = made["free_thresh"], made["occupied_thresh"]
        raise InputError(f"{origin}: free_thresh = {low:g} and occupied_thresh = {high:g} are not "
                      "0 <= free <= occupied <= 1")  # fmt: skip
    made["negate"] = bool(number(values.get("negate", 0), "negate", origin))
    made["mode"] = str(values.get("mode", MODES[0])).lower()
    if made["mode"] not in MODES:
        raise unknown("mode", made["mode"], MODES, origin)
    return made


def number(value: Any, key: str, origin: str) -> float:
    """A number of the YAML file; 1e-2, which YAML takes for a text, too. Raises InputError."""
    try:
        made = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{origin}: {key} = {value!r:.60} is not a number") from None
    if not math.isfinite(made):
        raise InputError(f"{origin}: {key} = {made:g} is not a number")
    return made


def contents(path: Path, values: dict[str, Any], data: bytes, name: str) -> DrawingContents:
    """The layers of a map. Raises InputError."""
    occupied, unseen = occupancy(image_of(data, f"{path}, {name}"), values)
    x, y, yaw = values["origin"]
    grid = RasterGrid((x, y), values["resolution"], yaw)
    origin = f"{path}, {name}"
    items = [Item(MAP, "box", partial(known_box, ~unseen, grid, origin))]
    items += [
        cells(layer, solid, grid, origin)
        for layer, solid in ((OCCUPIED, occupied), (UNKNOWN, unseen))
        if solid.any()
    ]
    return DrawingContents(
        path, tuple(items), tuple(item.layer for item in items), 1.0, roles=ROLES
    )


def image_of(data: bytes, origin: str) -> Image.Image:
    """The image, PGM or PNG. Raises InputError."""
    try:
        with warnings.catch_warnings():  # Pillow's, of many pixels; ours is an error
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(io.BytesIO(data), formats=("PPM", "PNG"))
        demand_few_cells(*image.size, origin)
        image.load()
    except InputError:
        raise
    except UnidentifiedImageError:
        raise InputError(f"{origin}: it is no PGM and no PNG image") from None
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as error:
        raise InputError(f"{origin}: it cannot be read: {' '.join(str(error).split())}") from None
    return image


def occupancy(image: Image.Image, values: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Which cells are occupied and which are unknown, (rows, columns), the lowest row first.

    As Nav2 has it: the mean of the colours, in the mode trinary of the alpha channel too, is
    white 1; negated or not it is compared with the thresholds, of which neither is reached by
    what is unknown. In the mode raw a value is a percentage, and above 100 unknown.
    """
    mode = values["mode"]
    clear = "A" in image.getbands() or "transparency" in image.info
    if image.mode.startswith(("I", "F")):  # 16 bits
        sums, most = np.asarray(image, np.int64), 65535
        clear = False
    else:
        bands = np.asarray(image.convert("RGBA" if clear else "RGB"))
        seen = bands if clear and mode == "trinary" else bands[..., :3]
        sums, most = seen.sum(axis=2, dtype=np.int64), 255 * seen.shape[2]
    table = np.arange(most + 1) / most
    if mode == "raw":
        percent = np.rint(table * 255.0)
        share = np.where(percent <= 100.0, percent / 100.0, np.nan)
    else:
        share = table if values["negate"] else 1.0 - table
    is_occupied = share > values["occupied_thresh"]
    is_free = share < values["free_thresh"]
    if mode == "raw":  # the ends are what they say, whatever the thresholds are
        is_occupied |= share == 1.0
        is_free |= share == 0.0
    sums = np.clip(sums, 0, most)
    occupied, unseen = is_occupied[sums], ~(is_occupied | is_free)[sums]
    if clear and mode == "scale":
        hidden = bands[..., 3] < 255
        occupied, unseen = occupied & ~hidden, unseen | hidden
    return occupied[::-1], unseen[::-1]


def known_box(known: np.ndarray, grid: RasterGrid, origin: str) -> list[Shape]:
    """The box around all cells that are free or occupied. Raises InputError."""
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        x, y = grid.origin
        raise InputError(f"{origin}: all of the map at {at((x, y))} is unknown")
    box = shapely.box(columns[0], rows[0], columns[-1] + 1, rows[-1] + 1)
    return [area("", rings(box, grid), origin)]
