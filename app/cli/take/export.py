"""`flockscope export`: a flock as one HTML file that runs it, without a server."""

from __future__ import annotations

import re
import shlex
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options.run_arguments import (
    GivenOptions,
    demand_alone,
    is_file,
    option_name,
    with_options,
)
from app.cli.take.source import is_recording
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.progress import Progress
from app.cli.terminal.usage import (
    Overwrite,
    PrintJson,
    Quiet,
    Rules,
    Settings,
    first_of,
    model_name,
)
from worlds.file_writer import PAGES, demand_writable, write_bytes
from worlds.input_error import InputError, unknown

if TYPE_CHECKING:
    from agents import Flock
    from app.viewer.gallery.saved_scene import SavedScene
    from app.viewer.lab.flock_page import PageWords


@with_options
def export(
    model: Annotated[
        str | None,
        typer.Argument(help="A model, a scene or a spec (TOML), or a rule (FILE.py)."),
    ] = None,
    rule: Rules = None,
    scene: Annotated[
        str | None, typer.Option(help="A scene: NAME of a built-in one, or FILE.toml.")
    ] = None,
    lesson: Annotated[str | None, typer.Option(help="A lesson of `flockscope class`.")] = None,
    paper: Annotated[
        str | None,
        typer.Option(help="An entry of `flockscope list papers`: its first run, or MODEL's."),
    ] = None,
    beside: Annotated[
        str | None,
        typer.Option(help="A second model, beside it in the same world from the same start."),
    ] = None,
    *,
    options: GivenOptions,
    settings: Settings = None,
    title: Annotated[str, typer.Option(help="Title of the page. \\[default: the model's]")] = "",
    out: Annotated[Path, typer.Option(help="HTML file.")] = Path("flock.html"),
    folder: Annotated[
        Path | None,
        typer.Option(
            help="Write the page and its parts into this folder of a web site; what shows them is "
            "there once for all pages. The page is called as --out."
        ),
    ] = None,
    everything: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Write a page of every scene and model into --folder, and index.html with them.",
        ),
    ] = False,
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Write a flock as one web page that runs by itself: offline, on a phone, from a file.

    The page runs the same compiled rule as here, with a slider for each parameter. It begins at
    the start that the seed gives. What a page cannot do is refused. What `flockscope run` takes to
    say which run it is, this takes too.
    """
    others = {"MODEL": model, "--rule": rule, "--set": settings} | {
        option_name(name): value for name, value in options.items()
    }
    if everything:
        named = {"--scene": scene, "--lesson": lesson, "--paper": paper, "--beside": beside}
        demand_alone("--all", named | others)
        if folder is None:
            raise InputError("--all needs --folder: it writes many pages")
        from app.cli.take.page_gallery import write_gallery

        told = write_gallery(folder, overwrite, quiet)
        if json_asked:
            typer.echo(as_json(told))
        return
    if folder is None:
        demand_writable("--out", out, overwrite, PAGES)
    elif out.name != str(out) or out.suffix.lower() not in PAGES:
        raise InputError(f"--out {str(out)!r} is not allowed: of a --folder it is NAME.html")
    elif folder.exists():
        demand_writable("--folder", folder / out.name, overwrite)
    if is_recording(model):
        raise InputError(f"{model} is a recording: a page runs a flock from its start")
    spec = Path(model) if model is not None and Path(model).suffix.lower() == ".toml" else None
    from agents import Flock
    from agents.spec import Spec
    from app.cli.run import build_flock
    from app.cli.take.page_gallery import write_folder
    from app.viewer.lab.flock_page import PageWords, flock_page, page_files, pair_page
    from app.viewer.run.paired_run import companion

    named = {"--scene": scene, "--lesson": lesson, "--paper": paper}
    chosen = [option for option, value in named.items() if value is not None]
    if len(chosen) > 1:
        raise InputError(f"{chosen[0]} cannot be given with {chosen[1]}: a page has one flock")
    if paper is not None:
        demand_alone("--paper", others | {"MODEL": None})
        flock, words = flock_of_paper(paper, model)
        second = None
    elif scene is not None or lesson is not None:
        demand_alone(chosen[0], others)
        opened = scene_to_export(scene) if scene is not None else lesson_to_export(lesson or "")
        flock, second = Flock(opened.spec), opened.beside
        words = PageWords.of_scene(opened, f"flockscope export {chosen[0]} {scene or lesson}")
    else:
        name = None if spec else first_of(model_name(model), rule)
        flock = build_flock(spec, name, options, settings or [], {}, quiet)
        words = PageWords() if spec is None else words_of_file(spec)
        second = None
    if beside is not None:
        second = Spec(beside)
    if second is not None and folder is not None:
        raise InputError("two flocks beside each other are one file: leave --folder out")
    if second is not None and words.steps:
        raise InputError("the steps of a lesson are for one flock: leave --beside out")
    other = None if second is None else companion(flock, second)
    if title:
        words = replace(words, title=title)
    if not quiet:
        print_stderr(f"flockscope: compiling {flock.model.name} for the page takes some seconds")
    with Progress(f"compiling {flock.model.name} for the page", quiet) as progress:
        if other is not None:
            page = pair_page(flock, other, words, progress.update).encode()
        elif folder is None:
            page = flock_page(flock, words, progress.update).encode()
        else:
            files = page_files(flock, out.stem, words, progress.update)
    if folder is None:
        sizes = {out: len(page)}
        write_bytes("--out", out, page, overwrite, PAGES)
    else:
        out = folder / out.name
        sizes = write_folder(folder, files, overwrite)
    if json_asked:
        told = {"page": str(out), "model": flock.model.name, "bytes": sum(sizes.values())}
        if folder is not None:
            told["files"] = {path.name: size for path, size in sizes.items()}
        typer.echo(as_json(told))
    if not quiet:
        print_written_files(*sizes)


def scene_to_export(name: str) -> SavedScene:
    """A built-in scene, or that of a file. Raises InputError."""
    from app.viewer.gallery.file_opener import opened_file
    from app.viewer.gallery.saved_scene import SavedScene
    from app.viewer.gallery.scene_collection import find_scene

    opened = opened_file(name) if is_file(name) else find_scene(name)
    if not isinstance(opened, SavedScene):
        raise InputError(f"{name} is a recording: a page runs a flock from its start")
    return opened


def words_of_file(path: Path) -> PageWords:
    """What a scene's file says of it; nothing of a spec's, which has no words."""
    from app.viewer.gallery.saved_scene import read_scene
    from app.viewer.lab.flock_page import PageWords

    content, command = path.read_bytes(), f"flockscope export {shlex.quote(path.name)}"
    if "run" not in tomllib.loads(content.decode("utf-8-sig")):
        return PageWords(command=command)
    return PageWords.of_scene(read_scene(path.name, content), command)


def lesson_to_export(name: str) -> SavedScene:
    """A lesson, for who is alone with it: of what to try the first sentence, as what follows speaks
    of a class. Raises InputError."""
    from app.viewer.gallery.lessons.lessons import lesson_names
    from app.viewer.gallery.scene_collection import find_lesson

    if name not in lesson_names():
        raise unknown("lesson", name, lesson_names())
    lesson = find_lesson(name)
    return replace(lesson, tries=re.split(r"(?<=\.) ", lesson.tries)[0])


def flock_of_paper(name: str, label: str | None) -> tuple[Flock, PageWords]:
    """The first run of a paper's entry, or of a model or label of it. Raises InputError."""
    from app.studies.experiment import flock_of
    from app.studies.experiment_reader import find_experiment
    from app.viewer.lab.flock_page import PageWords

    experiment = find_experiment(name).select([label] if label else [], [])
    if not experiment.cases:
        raise InputError(f"{name} has no run of a flock: a page runs one")
    case = experiment.cases[0]
    shown = f" {label}" if label else ""
    words = PageWords(
        title=f"{experiment.title}: {case.label}",
        watch=f"{experiment.source}, run 1 of {experiment.runs}.",
        command=f"flockscope export{shown} --paper {name}",
    )
    return flock_of(case, 1), words
