"""`flockscope formation`: what birds save by flying in each other's upwash."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.progress import Progress
from app.cli.terminal.usage import PrintJson, command_group
from app.results_folder import demand_folder, picture_files
from app.settings import check_whole_number, numbers
from worlds.input_error import InputError
from worlds.memory import demand_memory

Core = Annotated[float, typer.Option(help="Radius of the vortices' cores, in spans; 0 for none.")]
Behind = Annotated[float, typer.Option(help="How far behind the other, in spans; inf is allowed.")]
Above = Annotated[float, typer.Option(help="How far above the other, in spans.")]
Span = Annotated[float, typer.Option(help="Wing span b, m.")]
Out = Annotated[Path, typer.Option(help="Folder for pictures and numbers.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace what the folder has of these results.")
]
Pictures = Annotated[bool, typer.Option(help="Draw the picture as PNG and SVG.")]
Json = PrintJson
Quiet = Annotated[bool, typer.Option("--quiet", help="No messages.")]

MOST_DRAWS = 1_000_000
BYTES_OF_A_DRAW = 32
"""Of each bird: its place and what it saves."""
FOLDER = Path("results/formation")


def spacing(
    core: Core = 0.04,
    behind: Behind = math.inf,
    above: Above = 0.0,
    span: Span = 2.5,
    out: Out = FOLDER,
    pictures: Pictures = True,
    overwrite: Overwrite = False,
    json_asked: Json = False,
    quiet: Quiet = False,
) -> None:
    """Print the wing-tip spacing at which a bird saves most, and (2.8) of the thesis."""
    demand("--core", core, 0.0, 1.0)
    demand("--behind", behind, -20.0, math.inf)
    demand("--above", above, -20.0, 20.0)
    demand("--span", span, 0.01, 100.0)
    demand_folder("--out", out, ("spacing.csv", *picture_files("spacing", pictures)), overwrite)
    from agents.observables.formation import THESIS_SPACING, best_spacing, upwash_share
    from app.formation import TIPS, curve, draw_spacing, table, write_picture

    best = best_spacing(core, behind, above)
    at_thesis = float(upwash_share(behind, 1.0 + THESIS_SPACING, above, core))
    rows = zip(TIPS, curve(core, behind, above), curve(0.0, behind, above), strict=True)
    files = table(out, "spacing", ["tip_per_span", "saved", "saved_without_core"], rows)
    if pictures:
        files |= write_picture(
            out, "spacing", lambda fig: draw_spacing(fig, core, behind, above, best)
        )
    result = {
        "core": core,
        "behind": behind,
        "above": above,
        "best": {"tip": best.tip, "aside": 1.0 + best.tip, "saved": best.saved},
        "thesis": {"tip": THESIS_SPACING, "aside": 1.0 + THESIS_SPACING, "saved": at_thesis},
        "span": span,
    }
    lines = [
        f"best wing-tip spacing {best.tip:+.4f} b = {best.tip * span:+.3f} m,"
        f" middles {(1 + best.tip) * span:.3f} m apart: {100 * best.saved:.1f} % of the induced"
        " drag saved",
        f"(2.8)                 {THESIS_SPACING:+.4f} b = {THESIS_SPACING * span:+.3f} m,"
        f" middles {(1 + THESIS_SPACING) * span:.3f} m apart: {100 * at_thesis:.1f} % saved there",
    ]
    print_result(result, lines, files, json_asked, quiet)


def vee(
    birds: Annotated[int, typer.Option(help="Birds in the V.")] = 8,
    jitter: Annotated[
        str, typer.Option(help="Standard deviations of every coordinate, in spans.")
    ] = "0,0.1,0.2,0.3",
    draws: Annotated[int, typer.Option(help="Draws for each jitter.")] = 1000,
    step: Annotated[float, typer.Option(help="How far behind the next, in spans.")] = 0.5,
    tip: Annotated[
        float | None, typer.Option(help="Wing-tip spacing in spans. \\[default: the best]")
    ] = None,
    induced: Annotated[float, typer.Option(help="Share of the power that is induced.")] = 0.35,
    energy: Annotated[
        float | None,
        typer.Option(help="J/m of a bird alone. \\[default: the thesis's aircraft in trim]"),
    ] = None,
    speed: Annotated[float, typer.Option(help="Speed of that aircraft, m/s.")] = 3.5,
    seed: Annotated[int, typer.Option(help="Seed of the draws.")] = 0,
    out: Out = FOLDER,
    pictures: Pictures = True,
    overwrite: Overwrite = False,
    json_asked: Json = False,
    quiet: Quiet = False,
) -> None:
    """Print what a V of birds saves, exact and with jitter: percent and joules per metre."""
    if not 1 <= birds <= 200:
        raise InputError(f"--birds {birds} is not allowed: a whole number from 1 to 200 is needed")
    check_whole_number("--draws", draws, 1, MOST_DRAWS)
    check_whole_number("--seed", seed, 0)
    demand("--step", step, -6.0, 6.0)
    demand("--induced", induced, 0.0, 1.0)
    if tip is not None:
        demand("--tip", tip, -1.0, 5.0)
    if energy is not None:
        demand("--energy", energy, 0.0, 1e6)
    sizes = numbers("--jitter", jitter)
    for size in sizes:
        demand("--jitter", size, 0.0, 10.0)
    demand_memory(f"--draws {draws}", float(draws) * birds * BYTES_OF_A_DRAW)
    demand_folder("--out", out, ("vee.csv", *picture_files("vee", pictures)), overwrite)
    from agents.observables.formation import vee as placed
    from agents.observables.formation import vee_saved
    from app.formation import draw_vee, table, write_picture

    alone = energy_per_metre(speed) if energy is None else energy
    rows = []
    with Progress("vee", quiet) as progress:
        for done, size in enumerate(sizes):
            progress.update(done / len(sizes))
            shares = vee_saved(birds, size, draws if size > 0.0 else 1, step, tip, seed)
            rows.append(row(size, shares.mean(axis=1), induced, alone))
    files = table(out, "vee", list(rows[0]), (list(row.values()) for row in rows))
    exact = vee_saved(birds, step=step, tip=tip)[0]
    if pictures:
        places = placed(birds, step, tip)
        files |= write_picture(out, "vee", lambda figure: draw_vee(figure, places, exact, rows))
    result = {
        "birds": birds,
        "step": step,
        "draws": draws,
        "seed": seed,
        "induced_share": induced,
        "energy_alone": alone,
        "exact": exact,
        "rows": rows,
    }
    lines = [
        f"a V of {birds}, {step:g} b from row to row; {100 * induced:g} % of the power induced;"
        f" alone {alone:.3f} J/m",
        "jitter/b  induced drag saved  power saved (5 to 95 % of draws)    J/m a bird saves",
    ]
    lines += [
        f"{row['jitter']:8.2f}  {row['saved']:17.1f} %  {row['power']:9.1f} %"
        f" ({row['power_5']:.1f} to {row['power_95']:.1f})  {row['energy']:22.4f}"
        for row in rows
    ]
    print_result(result, lines, files, json_asked, quiet)


def draw_saving_map(
    core: Core = 0.04,
    behind: Annotated[float, typer.Option(help="Where the wake is cut across, in spans.")] = 1.0,
    above: Above = 0.0,
    out: Out = FOLDER,
    overwrite: Overwrite = False,
    json_asked: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw what a bird saves at any place behind, beside and above another."""
    demand("--core", core, 0.0, 1.0)
    demand("--behind", behind, -1.5, 6.0)
    demand("--above", above, -20.0, 20.0)
    demand_folder("--out", out, ("map.csv", *picture_files("map")), overwrite)
    from agents.observables.formation import best_spacing
    from app.formation import ASIDE, BACK, draw_behind, shares_from_above, table, write_picture

    best = best_spacing(core, behind)
    rows = (
        (back, aside, value)
        for back, line in zip(BACK, shares_from_above(core, above), strict=True)
        for aside, value in zip(ASIDE, line, strict=True)
    )
    files = table(out, "map", ["behind_per_span", "aside_per_span", "saved"], rows)
    files |= write_picture(
        out, "map", lambda figure: draw_behind(figure, core, above, behind, best)
    )
    result = {"core": core, "behind": behind, "above": above, "best": best._asdict()}
    line = (
        f"{behind:g} b behind a bird the best wing-tip spacing is {best.tip:+.4f} b:"
        f" {100 * best.saved:.1f} % of the induced drag saved"
    )
    print_result(result, [line], files, json_asked, quiet)


def row(jitter: float, shares: Any, induced: float, alone: float) -> dict[str, float]:
    """A line of the table: percentages of the draws' mean shares (draws,), and joules per metre."""
    import numpy as np

    low, high = np.percentile(100.0 * induced * shares, [5.0, 95.0])
    mean = float(shares.mean())
    return {
        "jitter": jitter,
        "saved": 100.0 * mean,
        "power": 100.0 * induced * mean,
        "power_5": float(low),
        "power_95": float(high),
        "energy": induced * mean * alone,
    }


def energy_per_metre(speed: float) -> float:
    """Energy per metre of the thesis's aircraft in trim, J/m. Raises InputError."""
    from agents.flight.aircraft import Aircraft
    from agents.flight.trim import trim

    return trim(Aircraft(), speed).energy_per_metre


def demand(option: str, value: float, low: float, high: float) -> None:
    """Refuse a number outside [low, high]. Raises InputError naming the option."""
    if not low <= value <= high:
        raise InputError(f"{option} {value:g} is outside [{low:g}, {high:g}]")


def print_result(
    result: dict[str, Any], lines: list[str], files: dict[str, Path], json_asked: bool, quiet: bool
) -> None:
    """Print the outcome as lines or as JSON, and where the files are."""
    if json_asked:
        typer.echo(as_json(result | {"files": {kind: str(path) for kind, path in files.items()}}))
    else:
        typer.echo("\n".join(lines))
    if not quiet:
        print_written_files(*files.values())


formation = command_group(
    "Say what birds save by each other's upwash.",
    {
        "spacing": spacing,
        "vee": vee,
        "map": draw_saving_map,
    },
)
