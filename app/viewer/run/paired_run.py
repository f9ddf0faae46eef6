"""Two models side by side: the same world, the same start, one set of controls."""

from __future__ import annotations

import contextlib
import io
import math
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from agents.catalogue import MODELS
from agents.catalogue import model as find_model
from agents.flock import Flock
from agents.kinds import ORDINARY
from agents.models.declare import DeclaredParameter, declared
from agents.spec import Spec
from app.viewer.run.flock_run import ComparedFlockError, FlockRun, StrayAgentError, describe_error
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

ROUNDING = 1e-9
"""Share of a tick by which sums of ticks may be off and yet make a whole one."""


@contextlib.contextmanager
def naming_errors(flock: Flock) -> Iterator[None]:
    """Whatever is raised within says which of two flocks it comes from."""
    title = flock.model.title
    try:
        yield
    except (InputError, ArithmeticError, StrayAgentError) as error:
        kind = next(
            failure
            for failure in (InputError, ArithmeticError, StrayAgentError)
            if isinstance(error, failure)
        )
        raise kind(f"{title}: {error}") from error
    except Exception as error:
        raise ComparedFlockError(f"{title}: {describe_error(error)}") from error


def shared_parameters(
    first: Mapping[str, DeclaredParameter], second: Mapping[str, DeclaredParameter]
) -> frozenset[str]:
    """Names of the parameters that two models declare alike: symbol, unit, kind and default.

    One slider moves them in both models. Of parameters that only have a name in common, or that
    each of the models was published with at a value of its own, each model has its own.
    """
    return frozenset(
        name
        for name, parameter in first.items()
        if name in second and is_same_parameter(parameter, second[name])
    )


def is_same_parameter(parameter: DeclaredParameter, other: DeclaredParameter) -> bool:
    """Whether two parameters are one and the same."""
    return all(
        getattr(parameter, part) == getattr(other, part)
        for part in ("name", "symbol", "unit", "kind", "choices", "default")
    )


def parameters_by_name(flock_or_model: Any) -> dict[str, DeclaredParameter]:
    """The declared parameters of a parameter model, by name."""
    return {parameter.name: parameter for parameter in declared(flock_or_model)}


def shared_model_parameters(first: str, second: str) -> frozenset[str]:
    """The same for models by name.

    >>> sorted(shared_model_parameters("vem", "ivem-a"))
    ['eta', 'k', 'neighbours', 'r', 'v0']
    """
    return shared_parameters(
        parameters_by_name(MODELS[first].parameters), parameters_by_name(MODELS[second].parameters)
    )


def companion(first: Flock, beside: Spec) -> Flock:
    """The flock of a second model, at the start of the first flock, to the bit.

    It has the world, seed, turns, noise and information agents of the first, and its values of
    what the models share: where agents differ in that, each has the same number in both flocks, as
    it is drawn by seed and identity. A model that knows no information agents takes them for
    ordinary ones. It has no kinds of agents: it begins where the ordinary agents of the first do.
    Positions and headings are the same, and speeds where both bodies have free ones: agents of a
    body of one speed go at that, and beside them others begin as they do alone.
    Raises InputError, with the model's title, if it cannot be in this world or at these values.
    """
    model = find_model(beside.model)
    if model is first.model:
        raise InputError(f"beside = {model.name!r} is the model itself: another one is needed")
    values = first.all_parameters
    shared_values = {
        name: values[name] for name in shared_model_parameters(first.model.name, model.name)
    }
    try:
        spec: Spec = first.options.with_parameters(
            shared_values | beside.all_parameters,
            model=model.name,
            world=first.world,
            kinds=(),
            to={},
        )
    except InputError as refusal:
        raise InputError(f"{model.title}: {refusal}") from None
    arrays, rows = None, first.rows_of(ORDINARY)
    if spec.informed and not model.rule.led:
        arrays = {name: getattr(first, name)[rows] for name in ("position", "heading")}
        if first.model.body.speed is None:
            arrays["speed"] = first.speed[rows]
        spec = spec.but(informed=0)
    try:
        flock = Flock(spec, threads=first.threads, start=arrays, interpret=first.interpret)
    except InputError as refusal:
        raise InputError(f"{model.title}: {refusal}") from None
    if arrays is not None:
        flock.heading[:] = first.heading[rows]  # To the bit: given headings are normalised again.
        flock.ids[:] = first.ids[rows]
    return flock


class PairedRun(FlockRun):
    """The run of a flock with that of a second one, which keeps up with its time."""

    second: FlockRun

    def __init__(
        self,
        flock: Flock,
        second: Flock,
        number: int,
        request: FrameRequest,
        watched: frozenset[str] = frozenset(),
    ):
        self.second = FlockRun(second, number, FrameRequest(), watched)
        super().__init__(flock, number, request, watched)
        self.shared = shared_parameters(
            parameters_by_name(type(flock.parameters)), parameters_by_name(type(second.parameters))
        )
        self.owed = 0.0
        """Part of a tick of the second flock by which it is behind the first."""
        self.set_request(request)

    @property
    def beside_values(self) -> dict[str, Any]:
        """The parameters that only the second flock has, name -> value."""
        values = self.second.values
        return {name: value for name, value in values.items() if name not in self.shared}

    @property
    def redrawn(self) -> dict[tuple[str, bool], int]:
        """How many numbers were drawn again, of the second flock where only that has them."""
        second = self.second.flock.redrawn.items()
        own = {(name, True): number for name, number in second if name not in self.shared}
        return super().redrawn | own

    def set_request(self, request: FrameRequest) -> None:
        """Change what frames hold; only the flock that is meant is looked at from close."""
        nobody = replace(request, row=None)
        self.camera.set_request(nobody if request.beside else request)
        second = request if request.beside else nobody
        self.second.camera.set_request(replace(second, others=request.others_beside))

    def advance(self, ticks: int) -> None:
        """Run ticks of the first flock, and as many of the second as take the same time."""
        with naming_errors(self.flock):
            super().advance(ticks)
        due = self.owed + ticks * ticks_per_tick(self.flock, self.second.flock)
        whole_ticks = math.floor(due + ROUNDING)
        self.owed = max(0.0, due - whole_ticks)
        with naming_errors(self.second.flock):
            self.second.advance(whole_ticks)

    def look(self, closely: bool, measured: bool = True) -> Frame:
        """A frame of the first flock that holds one of the second; raises as `FlockRun.look`."""
        with naming_errors(self.flock):
            frame = super().look(closely, measured)
        trouble_count = len(self.second.troubles)
        with naming_errors(self.second.flock):
            compared_frame = self.second.look(closely, measured)
        for trouble in self.second.troubles[trouble_count:]:
            self.try_to_look(partial(self.raise_named, trouble))
        scale, other = frame.speed_scale, compared_frame.speed_scale
        if frame.unit == compared_frame.unit:
            scale = other = max(scale, other)
        compared_frame = replace(
            compared_frame, speed_scale=other, title=self.second.flock.model.title
        )
        return replace(
            frame, speed_scale=scale, title=self.flock.model.title, beside=compared_frame
        )

    def raise_named(self, trouble: Exception) -> None:
        """Raise what the second flock had trouble with, named."""
        with naming_errors(self.second.flock):
            raise trouble

    def allowed(self, name: str, value: Any, beside: bool = False) -> Any:
        """The value nearest to the wanted one that keeps the zones in order, of both if shared."""
        if beside:
            return self.second.allowed(name, value)
        value = super().allowed(name, value)
        return self.second.allowed(name, value) if name in self.shared else value

    def set(self, name: str, value: Any, beside: bool = False) -> None:
        """Give a parameter a value, in both flocks if they share it. Refused by one, by both."""
        if beside:
            with naming_errors(self.second.flock):
                self.second.set(name, value)
            return
        before = self.values
        super().set(name, value)
        if name not in self.shared:
            return
        try:
            with naming_errors(self.second.flock):
                self.second.set(name, value)
        except InputError:
            self.flock.set(**before)
            raise

    def place(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        """Put an information agent somewhere, in both flocks if it is one in both."""
        super().place(row, position, heading)
        second = self.second.flock
        rows = np.flatnonzero((second.ids == self.flock.ids[row]) & second.informed)
        for other in rows.tolist():
            self.second.place(other, position, heading)

    def spec(self) -> bytes:
        """The specs of both flocks, a ZIP."""
        return self.zip_files("toml", super().spec(), self.second.spec())

    def save(self) -> bytes:
        """The states of both flocks, a ZIP."""
        return self.zip_files("parquet", super().save(), self.second.save())

    def zip_files(self, suffix: str, *contents: bytes) -> bytes:
        """A file of each flock in a ZIP, numbered and named by their models."""
        names = (run.flock.model.name for run in self.both)
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as pack:
            for number, (name, content) in enumerate(zip(names, contents, strict=True), 1):
                pack.writestr(zipfile.ZipInfo(f"{number}-{name}.{suffix}"), content)
        return buffer.getvalue()


def ticks_per_tick(first: Flock, second: Flock) -> float:
    """Ticks of the second flock that last as long as one of the first; 1 without a common unit."""
    return ratio(first.dt, first.model.body.unit, second.dt, second.model.body.unit)


def ratio(dt: float, unit: str, other_dt: float, other_unit: str) -> float:
    """How many of the others' ticks last as long as one; 1 where time is not counted alike.

    >>> ratio(0.1, "s", 0.02, "s"), ratio(1.0, "ticks", 0.02, "s")
    (5.0, 1.0)
    """
    return dt / other_dt if unit == other_unit else 1.0


def pace_note(first: Frame, second: Frame) -> str:
    """How the ticks of two flocks go together, in a line; nothing if they last equally long.

    >>> from types import SimpleNamespace as Some
    >>> pace_note(Some(dt=0.1, unit="s"), Some(dt=0.02, unit="s"))
    'Ticks of 0.1 s and of 0.02 s: 5 ticks of the second to one of the first.'
    """
    if first.unit != second.unit:
        clocks = (frame.unit if frame.unit == "ticks" else f"{frame.dt:g} {frame.unit}"
                  for frame in (first, second))  # fmt: skip
        return f"Time is not counted alike ({', '.join(clocks)}): both go tick by tick."
    if first.dt == second.dt:
        return ""
    each = ratio(first.dt, first.unit, second.dt, second.unit)
    return (
        f"Ticks of {first.dt:g} {first.unit} and of {second.dt:g} {second.unit}: {each:.4g} "
        f"tick{'s' * (each != 1)} of the second to one of the first."
    )
