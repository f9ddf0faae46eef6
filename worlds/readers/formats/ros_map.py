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
from worlds.readers.drawn_shapes import Shape, area, format_place
from worlds.readers.formats.grid import RasterGrid, cells, demand_few_cells, rings
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
            yaml_names = [name for name in names if name.lower().endswith((".yaml", ".yml"))]
            if len(yaml_names) != 1:
                raise InputError(
                    f"{path} holds {len(yaml_names)} YAML files: one, and the image that it "
                    "names, are a map of ROS"
                )
            text = member(archive, yaml_names[0], LARGEST_YAML, path).decode("utf-8", "replace")
            values = settings(text, f"{path}, {yaml_names[0]}")
            image_name = PurePosixPath(str(values["image"])).name
            images = [name for name in names if PurePosixPath(name).name == image_name]
            if not images:
                raise InputError(
                    f"{path} does not hold the image {image_name!r} that {yaml_names[0]} names"
                )
            data = member(archive, images[0], LARGEST, path)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        raise InputError(f"{path} is not a ZIP file that can be read: {error}") from None
    return contents(path, values, data, image_name)


def member(archive: zipfile.ZipFile, name: str, limit: int, path: Path) -> bytes:
    """A file in a ZIP file, of a bounded size, whatever its header says. Raises InputError."""
    with archive.open(name) as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise InputError(f"{path}, {name}: it has more than {limit} bytes")
    return data


class PlainLoader(yaml.SafeLoader):
    """The safe loader without aliases.

    Some hundred bytes of them stand for billions of values, which a message would write.
    """

    def compose_node(self, *args: Any) -> Any:
        """A node of the document. Raises YAMLError for an alias."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("it has aliases (*name), which no map of ROS needs")
        return super().compose_node(*args)


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
    missing_keys = [key for key in NEEDED if key not in values]
    if missing_keys:
        raise InputError(f"{origin} is not a map of ROS: it has no {' and no '.join(missing_keys)}")
    if not isinstance(values["image"], str) or not values["image"].strip("/"):
        raise InputError(f"{origin}: image = {values['image']!r:.60} is no name of a file")
    parsed: dict[str, Any] = {"image": values["image"]}
    parsed["resolution"] = number(values["resolution"], "resolution", origin)
    if parsed["resolution"] <= 0.0:
        raise InputError(f"{origin}: resolution = {parsed['resolution']:g} is not a length > 0")
    pose = values["origin"]
    if not isinstance(pose, list) or len(pose) != 3:
        raise InputError(f"{origin}: origin = {pose!r:.60} is not [x, y, yaw]")
    parsed["origin"] = [number(value, "origin", origin) for value in pose]
    for key, default in THRESHOLDS.items():
        parsed[key] = number(values.get(key, default), key, origin)
    if not 0.0 <= parsed["free_thresh"] <= parsed["occupied_thresh"] <= 1.0:
        low, high = parsed["free_thresh"], parsed["occupied_thresh"]
        raise InputError(f"{origin}: free_thresh = {low:g} and occupied_thresh = {high:g} are not "
                      "0 <= free <= occupied <= 1")  # fmt: skip
    parsed["negate"] = bool(number(values.get("negate", 0), "negate", origin))
    parsed["mode"] = str(values.get("mode", MODES[0])).lower()
    if parsed["mode"] not in MODES:
        raise unknown("mode", parsed["mode"], MODES, origin)
    return parsed


def number(value: Any, key: str, origin: str) -> float:
    """A number of the YAML file; 1e-2, which YAML takes for a text, too. Raises InputError."""
    try:
        parsed = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{origin}: {key} = {value!r:.60} is not a number") from None
    if not math.isfinite(parsed):
        raise InputError(f"{origin}: {key} = {parsed:g} is not a number")
    return parsed


def contents(path: Path, values: dict[str, Any], data: bytes, name: str) -> DrawingContents:
    """The layers of a map. Raises InputError."""
    occupied, unknown = occupancy(image_of(data, f"{path}, {name}"), values)
    x, y, yaw = values["origin"]
    grid = RasterGrid((x, y), values["resolution"], yaw)
    origin = f"{path}, {name}"
    items = [Item(MAP, "box", partial(known_box, ~unknown, grid, origin))]
    items += [
        cells(layer, solid, grid, origin)
        for layer, solid in ((OCCUPIED, occupied), (UNKNOWN, unknown))
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
    has_alpha = "A" in image.getbands() or "transparency" in image.info
    if image.mode.startswith(("I", "F")):  # 16 bits
        sums, top = np.asarray(image, np.int64), 65535
        has_alpha = False
    else:
        bands = np.asarray(image.convert("RGBA" if has_alpha else "RGB"))
        counted_bands = bands if has_alpha and mode == "trinary" else bands[..., :3]
        sums, top = counted_bands.sum(axis=2, dtype=np.int64), 255 * counted_bands.shape[2]
    table = np.arange(top + 1) / top
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
    sums = np.clip(sums, 0, top)
    occupied, unknown = is_occupied[sums], ~(is_occupied | is_free)[sums]
    if has_alpha and mode == "scale":
        is_transparent = bands[..., 3] < 255
        occupied, unknown = occupied & ~is_transparent, unknown | is_transparent
    return occupied[::-1], unknown[::-1]


def known_box(is_known: np.ndarray, grid: RasterGrid, origin: str) -> list[Shape]:
    """The box around all cells that are free or occupied. Raises InputError."""
    rows, columns = np.flatnonzero(is_known.any(axis=1)), np.flatnonzero(is_known.any(axis=0))
    if not len(rows):
        x, y = grid.origin
        raise InputError(f"{origin}: all of the map at {format_place((x, y))} is unknown")
    box = shapely.box(columns[0], rows[0], columns[-1] + 1, rows[-1] + 1)
    return [area("", rings(box, grid), origin)]
