"""What a slider spans, in which steps, and which controls are changed.

viser's slider is linear over all that is allowed. The page's script `dials.js` draws another in its
place, of what is told here; the value, its box and what the server takes of a browser stay viser's.
"""

from __future__ import annotations

import functools
import html
import io
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

import viser

from agents.models.declare import DeclaredParameter, NumberParameter
from agents.models.slider_range import Range, is_wide, round_down, round_up
from app.figure import DRAWING
from app.front.viser_internals import identifier
from app.viewer.scene.shown.control import Control

# The papers' symbols for places that know no LaTeX, and their equations as pictures.

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "eta": "η",
    "theta": "θ", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "varphi": "φ", "chi": "χ", "psi": "ψ",
    "omega": "ω", "varepsilon": "ε", "Delta": "Δ", "Phi": "Φ", "Omega": "Ω", "ell": "ℓ",
    "sqrt": "√",
}  # fmt: skip
LOWERED = str.maketrans("0123456789+-aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉₊₋ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ")
RAISED = str.maketrans("0123456789*abcdefghijklmnoprstuvwxyz",
                       "⁰¹²³⁴⁵⁶⁷⁸⁹*ᵃᵇᶜᵈᵉᶠᵍʰⁱʲᵏˡᵐⁿᵒᵖʳˢᵗᵘᵛʷˣʸᶻ")  # fmt: skip
SMALL = {"_": LOWERED, "^": RAISED}


def plain_symbol(symbol: str) -> str:
    r"""A LaTeX symbol as text; what Unicode has no small figures for follows after a thin space.

    >>> tuple(map(plain_symbol, (r"v_{max}", r"\\eta", r"n_{c}", r"w^{nei}", r"v^0")))
    ('vₘₐₓ', 'η', 'n\u202fc', 'wⁿᵉⁱ', 'v⁰')
    """
    return as_text(symbol, small_figures)


def marked_symbol(symbol: str) -> str:
    r"""The same, with `_` and `^` before letters: a page that runs sets these below and above.

    >>> marked_symbol(r"w^{nei}"), marked_symbol("v_0")
    ('w^nei', 'v₀')
    """
    return as_text(symbol, small_digits)


def as_text(symbol: str, small: Callable[[re.Match[str]], str]) -> str:
    """A LaTeX symbol as text, with what stands below or above as `small` gives it."""
    text = re.sub(r"\\(?:mathrm|text|operatorname|mathcal)\b", "", symbol)
    text = re.sub(r"\\+([A-Za-z]+)", lambda match: GREEK.get(match[1], match[1]), text)
    text = re.sub(r"([_^])(\{[^{}]*\}|.)", small, text)
    return " ".join(re.sub(r"[{}\\]+", "", text).split(" "))


def small_digits(match: re.Match[str]) -> str:
    """Digits and signs in small figures; letters keep their mark."""
    written = match[2].strip("{}")
    has_letters = any(part.isalpha() for part in written)
    return f"{match[1]}{written}" if has_letters else small_figures(match)


def small_figures(match: re.Match[str]) -> str:
    """A subscript or superscript in small figures, where Unicode has them all."""
    sign, written = match[1], match[2].strip("{}")
    figures = SMALL[sign]
    has_all = all(ord(part) in figures for part in written)
    return written.translate(figures) if has_all else f"\N{NARROW NO-BREAK SPACE}{written}"


@functools.cache
def equation_svg(latex: str, size: float = 14.0) -> list[str | None]:
    r"""The lines of an equation, broken at `\qquad`, each as an SVG element.

    None stands for a line that matplotlib cannot set.
    """
    lines = [line.strip().rstrip(",") for line in latex.split(r"\qquad")]
    return [line_svg(in_mathtext(line), size) for line in lines if line]


def in_mathtext(latex: str) -> str:
    """LaTeX in the part of it that matplotlib knows."""
    latex = re.sub(r"\\([lgn]e)(?![A-Za-z])", r"\\\1q", latex)
    latex = latex.replace(r"\tfrac", r"\frac")
    latex = re.sub(r"\\frac(\w)", r"\\frac{\1}", latex)
    latex = re.sub(r"\\frac\{(\w)\}(\w)", r"\\frac{\1}{\2}", latex)
    latex = re.sub(r"\\[Bb]igg?([(\[])", r"\\left\1", latex)
    latex = re.sub(r"\\[Bb]igg?([)\]])", r"\\right\1", latex)
    return re.sub(r"\\begin\{cases\}(.*?)\\end\{cases\}", cases_in_a_row, latex, flags=re.S)


def cases_in_a_row(match: re.Match[str]) -> str:
    """Cases beside each other instead of below each other."""
    rows = [row.split("&") for row in match[1].split(r"\\")]
    return r";\quad ".join(r"\;\;(".join(part.strip() for part in row) + ")" for row in rows)


def line_svg(latex: str, size: float) -> str | None:
    """One line of mathematics as an SVG element in the colour of the text around it, named by its
    LaTeX; None where matplotlib cannot set it."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(0.01, 0.01))
    FigureCanvasSVG(figure)
    figure.text(0, 0, f"${latex}$", fontsize=size, math_fontfamily="cm")
    buffer = io.StringIO()
    try:
        with DRAWING, rc_context({"svg.fonttype": "path"}):
            figure.savefig(buffer, format="svg", bbox_inches="tight", transparent=True)
    except ValueError:
        return None
    text = buffer.getvalue().replace("#000000", "currentColor")
    name = html.escape(latex, quote=True)
    return f'<svg fill="currentColor" role="img" aria-label="{name}"{text.partition("<svg")[2]}'


FEWEST, MOST = 20, 200
"""Steps of a linear slider."""
DECIMALS = 8
"""The most that a box shows."""


@dataclass
class Dial:
    """The slider of one parameter."""

    one: NumberParameter
    control: Any
    begun: float
    """The value that a double click brings back."""
    shown: Range

    def fit(self) -> None:
        """Span what is proposed, and more where the value is outside: until what it began with is
        back."""
        value = self.control.value
        if value == self.begun:
            self.shown = self.one.proposed
        self.shown = widen_range(self.shown, value, self.one.bounds)

    def page_state(self) -> dict[str, Any]:
        """What the page is told of it."""
        low, high = self.shown
        return {
            "log": is_wide(low, high),
            "default": self.begun,
            "stops": slider_stops(low, high, step_of(self.one), self.begun),
        }


class Dials:
    """The sliders of a panel, and the marks of all its controls."""

    def __init__(self, gui: viser.GuiApi):
        self.place = gui.add_html("")
        self.marks = gui.add_html("")
        self.dials: list[Dial] = []
        self.controls: list[tuple[Any, Any]] = []
        """Each with the value that it began with."""
        self.told: list[Any] = []
        """Of which sliders the page has been told what they span."""

    def clear(self) -> None:
        """The controls are gone."""
        self.dials, self.controls = [], []

    def add(self, parameter: DeclaredParameter, control: Any) -> None:
        """Another control."""
        self.controls.append((control.value, control))
        if isinstance(parameter, NumberParameter):
            self.dials.append(Dial(parameter, control, control.value, parameter.proposed))

    def refresh(self) -> None:
        """Tell the page what sliders span and what is changed, if it is new."""
        for dial in self.dials:
            dial.fit()
        now = [(identifier(dial.control), dial.shown) for dial in self.dials]
        if now != self.told:
            self.told = now
            states = {identifier(dial.control): dial.page_state() for dial in self.dials}
            text = html.escape(json.dumps(states, separators=(",", ":")))
            self.place.content = f'<div data-dials="{text}" hidden></div>'
        marked = [identifier(control) for begun, control in self.controls if control.value != begun]
        content = label_style(marked)
        if content != self.marks.content:
            self.marks.content = content


def label_style(uuids: list[str]) -> str:
    """A style that marks the labels of controls."""
    if not uuids:
        return ""
    labels = ", ".join(f'label[for="{uuid}"]' for uuid in uuids)
    return (
        f"<style>:is({labels}) {{ color: var(--fs-accent); font-weight: 600; }}"
        f":is({labels})::before {{ content: '\u25cf\u2002'; font-size: 0.7em; }}</style>"
    )


def step_of(parameter: NumberParameter) -> float:
    """From one value to the next in a box."""
    return parameter.step or (parameter.high - parameter.low) / MOST


def widen_range(limits: Range, value: float, allowed: Range) -> Range:
    """A range that holds a value too, up to the next round number.

    A scale of logarithms has no place for 0; a value there stands at its left end.

    >>> widen_range((0.5, 20.0), 3.0, (0.1, 100.0)), widen_range((0.5, 20.0), 30.0, (0.1, 100.0))
    ((0.5, 20.0), (0.5, 50.0))
    """
    low, high = limits
    if value > high:
        high = min(allowed[1], round_up(value)) if value > 0.0 else allowed[1]
    elif value < low and (value > 0.0 or not is_wide(low, high)):
        low = max(
            allowed[0], round_down(value) if value > 0.0 else -round_up(-value) if value else 0.0
        )
    return low, high


def slider_stops(low: float, high: float, step: float, default: float) -> list[float]:
    """The values that a slider can be put on: both ends, the default, and round ones between.

    On a scale of logarithms they have two figures; else they are multiples of the step, or of a
    rounder one where they would be too many, or too few.

    >>> slider_stops(0.0, 1.0, 0.25, 0.3)[:8]
    [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35]
    >>> slider_stops(1.0, 500.0, 1.0, 30.0)[:12]
    [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1]
    """
    if is_wide(low, high):
        powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)))
        candidates = [float(f"{two}e{power - 1}") for power in powers for two in range(10, 100)]
    else:
        step = slider_step(low, high, step)
        places = 2 - math.floor(math.log10(step))
        candidates = [
            round(k * step, places) for k in range(math.ceil(low / step), math.ceil(high / step))
        ]
    return sorted({low, high, default, *(value for value in candidates if low < value < high)})


def slider_step(low: float, high: float, step: float) -> float:
    """The step of a linear slider; whole steps, which count something, are not divided."""
    steps = (high - low) / step
    if steps > MOST:
        return round_up((high - low) / MOST)
    return step if steps >= FEWEST or step >= 1.0 else round_down((high - low) / FEWEST)


def decimals(parameter: NumberParameter) -> int:
    """So many decimals has the box of a number: all of the declared ones, and three figures of the
    least of them."""
    numbers = [parameter.default, *parameter.bounds, step_of(parameter)]
    finest = min(abs(x) for x in numbers if x)
    written = (-int(Decimal(f"{x:.{DECIMALS}g}").normalize().as_tuple().exponent) for x in numbers)
    return min(DECIMALS, max(2, 2 - math.floor(math.log10(finest)), *written))


# Controls for the fields of a dataclass, made from how they are declared to be chosen.


class Form[T]:
    """A control for each field in `controls`, in groups; other fields keep their values.

    One that does not apply is out of sight, as is a group without any; it keeps its value.
    """

    def __init__(self, gui: viser.GuiApi, value: T, controls: Mapping[str, Control]):
        self.value = value
        self.controls = controls
        groups = dict.fromkeys(control.group for control in controls.values())
        self.folders = {group: gui.add_folder(group) for group in groups}
        self.handles: dict[str, Any] = {}
        for name, control in controls.items():
            with self.folders[control.group]:
                self.handles[name] = handle(gui, control, getattr(value, name))
        self.fit(value, ())

    def __getitem__(self, name: str) -> Any:
        """The control of a field."""
        return self.handles[name]

    def read(self, **instead: Any) -> T:
        """The dataclass as the controls have it, with other values `instead` of some."""
        values = {name: handle.value for name, handle in self.handles.items()} | instead
        return replace(self.value, **values)  # type: ignore[type-var]

    def fit(self, value: T, scene: Iterable[Any]) -> None:
        """Show those controls that apply to anything in the scene, as things are chosen now."""
        applies = {name: control.is_for(scene, value) for name, control in self.controls.items()}
        groups = {self.controls[name].group for name, is_shown in applies.items() if is_shown}
        for group, folder in self.folders.items():
            set_visible(folder, group in groups)
        for name, is_shown in applies.items():
            set_visible(self.handles[name], is_shown)


def set_visible(control: Any, visible: bool) -> None:
    """Show a control, or hide it; browsers are told only what changes."""
    if control.visible != visible:
        control.visible = visible


def handle(gui: viser.GuiApi, control: Control, value: Any) -> Any:
    """The control of one field."""
    if isinstance(value, bool):
        return gui.add_checkbox(control.label, value, hint=control.hint)
    if control.choices:
        return gui.add_dropdown(
            control.label, control.choices, initial_value=value, hint=control.hint
        )
    if control.typed:
        low, high, step = control.low, control.high, control.step
        return gui.add_number(control.label, value, min=low, max=high, step=step, hint=control.hint)
    return gui.add_slider(
        control.label, control.low, control.high, control.step, value, hint=control.hint
    )
