"""The papers' symbols for places that know no LaTeX, and their equations as pictures."""

from __future__ import annotations

import functools
import io
import re

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "eta": "η",
    "theta": "θ", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "varphi": "φ", "chi": "χ", "psi": "ψ",
    "omega": "ω", "varepsilon": "ε", "Delta": "Δ", "Phi": "Φ", "Omega": "Ω", "ell": "ℓ",
    "sqrt": "√",
}  # fmt: skip
LOWERED = str.maketrans("0123456789+-aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉₊₋ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ")
RAISED = str.maketrans("0123456789*", "⁰¹²³⁴⁵⁶⁷⁸⁹*")
SMALL = {"_": LOWERED, "^": RAISED}


def plain(symbol: str) -> str:
    r"""A LaTeX symbol as text; what Unicode has no small figures for keeps its `_` or `^`.

    >>> plain(r"v_{max}"), plain(r"\\eta"), plain(r"k_{IU}"), plain(r"w^{nei}"), plain(r"v^0")
    ('vₘₐₓ', 'η', 'k_IU', 'w^nei', 'v⁰')
    """
    text = re.sub(r"\\(?:mathrm|text|operatorname|mathcal)\b", "", symbol)
    text = re.sub(r"\\+([A-Za-z]+)", lambda found: GREEK.get(found[1], found[1]), text)
    text = re.sub(r"([_^])(\{[^{}]*\}|.)", small, text)
    return " ".join(re.sub(r"[{}\\]+", "", text).split())


def small(found: re.Match[str]) -> str:
    """A subscript or superscript in small figures, where Unicode has them all."""
    sign, written = found[1], found[2].strip("{}")
    figures = SMALL[sign]
    has_all = all(ord(one) in figures for one in written)
    return written.translate(figures) if has_all else f"{sign}{written}"


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


def cases_in_a_row(found: re.Match[str]) -> str:
    """Cases beside each other instead of below each other."""
    rows = [row.split("&") for row in found[1].split(r"\\")]
    return r";\quad ".join(r"\;\;(".join(part.strip() for part in row) + ")" for row in rows)


def line_svg(latex: str, size: float) -> str | None:
    """One line of mathematics as an SVG element; None where matplotlib cannot set it."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(0.01, 0.01))
    FigureCanvasSVG(figure)
    figure.text(0, 0, f"${latex}$", fontsize=size, math_fontfamily="cm")
    drawn = io.StringIO()
    try:
        with rc_context({"svg.fonttype": "path"}):
            figure.savefig(drawn, format="svg", bbox_inches="tight", transparent=True)
    except ValueError:
        return None
    text = drawn.getvalue()
    return text[text.index("<svg") :]
