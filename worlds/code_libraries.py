"""Link the functions that a loop calls into it once, when it is made machine code.

numba optimises every function by itself, copies into it all that it calls, optimises it again and
makes machine code of it. The hundred functions of a loop are all inlined into it, so here they stay
as they were written down, and only the loop is optimised and made machine code: half to three
quarters of the time until a model's first tick (`benchmarks/pages/first_start.py`).

This builds on inner classes of numba, as they are in the versions of `TRIED`. Another version
compiles in its own way.
"""

from __future__ import annotations

import copy
import functools
import re
from collections import Counter
from collections.abc import Callable
from typing import Any

import numba
from llvmlite.binding import Target, get_process_triple, parse_assembly
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler

TRIED = ("0.68.",)
"""Versions of numba that this was tried with, by how they begin."""


LEVELS = "x86-64-v4", "x86-64-v3"
"""The levels of x86-64 that loops are made for, the lowest last: it rounds a product and a sum as
one."""


@functools.cache
def lowest_level() -> Any:
    """The machine of the lowest level."""
    target = Target.from_triple(get_process_triple())
    return target.create_target_machine(cpu=LEVELS[-1], features="", opt=3)


def optimise(module: Any, codegen: Any) -> Any:
    """The module of a loop, optimised; for all levels of x86-64 as for the lowest.

    How many terms of a sum are added at once is decided here, by the registers that there are, and
    which product and sum are rounded as one. So results have the same bits on every level, while
    the machine code that is made of it uses the registers of this one.
    """
    if codegen._get_host_cpu_name() not in LEVELS:
        passes, builder = codegen._module_pass_manager()
        passes.run(module, builder)
        return module
    optimiser = copy.copy(codegen)
    optimiser._tm = lowest_level()
    passes, builder = optimiser._module_pass_manager()
    passes.run(module, builder)
    settled = parse_assembly(settle_rounding(str(module)))
    settled.name = module.name
    return settled


KIND = r"double|<\d+ x double>"
VALUE = r"%[-\w.$]+|splat \(double [^)]*\)|zeroinitializer|<double [^>]*>|-?[\d.]+e[-+]\d+|0x\w+"
PRODUCT = re.compile(rf"  (%\S+) = fmul [\w ]*contract ({KIND}) ({VALUE}), ({VALUE})$", re.M)
SUM = re.compile(rf"  (%\S+) = (fadd|fsub) [\w ]*contract ({KIND}) ({VALUE}), ({VALUE})$", re.M)
FREEDOM = re.compile(r"(?<= = )(f\w+)((?: (?:reassoc|nsz|arcp|contract))+)(?= )")
NAME = re.compile(r"%[-\w.$]+")
"""Of LLVM code: types of numbers, values, products and sums, what operations allow, and names."""


def settle_rounding(text: str) -> str:
    """LLVM code that says which product and sum are rounded as one, and leaves nothing open.

    As it makes machine code LLVM would choose both by the registers and the times of each CPU.
    """
    bodies = [fuse_products(body) for body in re.split(r"(?m)^(?=define )", text)]
    settled = FREEDOM.sub(lambda match: match[1] + " nsz" * ("nsz" in match[2]), "".join(bodies))
    for kind in sorted(set(re.findall(rf"call nsz ({KIND}) @llvm\.fma\.", settled))):
        declaration = f"declare {kind} @{fused_product(kind)}({kind}, {kind}, {kind})"
        settled += "" if declaration in settled else f"\n{declaration}\n"
    return settled


def fused_product(kind: str) -> str:
    """The name of LLVM's function a * b + c, which rounds once.

    >>> fused_product("double"), fused_product("<8 x double>")
    ('llvm.fma.f64', 'llvm.fma.v8f64')
    """
    width = re.sub(r"\D", "", kind)
    return f"llvm.fma.v{width}f64" if width else "llvm.fma.f64"


def fuse_products(body: str) -> str:
    """A function in which each sum with a product that only it uses is rounded as one with it."""
    uses = Counter(NAME.findall(body))
    factors = {
        name: (one, other) for name, _, one, other in PRODUCT.findall(body) if uses[name] == 2
    }  # named where it is made, and where it is used

    def fuse(match: re.Match) -> str:
        name, operation, kind, first, second = match.groups()
        minus = f"%minus.{name[1:]}"
        if first in factors:
            (one, other), rest = factors[first], second
        elif second in factors:
            (one, other), rest = factors[second], first
        else:
            return match[0]
        lines = ""
        if operation == "fsub":
            negated = rest if first in factors else one
            lines = f"  {minus} = fneg {kind} {negated}\n"
            one, rest = (one, minus) if first in factors else (minus, rest)
        arguments = ", ".join(f"{kind} {value}" for value in (one, other, rest))
        return f"{lines}  {name} = call nsz {kind} @{fused_product(kind)}({arguments})"

    return SUM.sub(fuse, body)


def take_in(library: CPUCodeLibrary, module: Any) -> None:
    """Add a module to a library as it is."""
    module.data_layout = library._codegen._data_layout
    library._final_module.link_in(module)


class PartLibrary(JITCodeLibrary):
    """What was written down of a function that others call: neither optimised nor machine code."""

    add_llvm_module = take_in

    def finalize(self) -> None:
        """Let whoever takes it in inline it, and drop it where nobody calls it."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "linkonce_odr"
        self._finalized = True

    @property
    def own_module(self) -> Any:
        """Its module, without what it calls."""
        self._ensure_finalized()
        return self._final_module

    def _get_module_for_linking(self) -> Any:
        """Its module with all that it calls, for functions that numba compiles in its own way."""
        linked_module = self.own_module.clone()
        for library in reached_libraries(self):
            linked_module.link_in(module_of(library), preserve=True)
        return linked_module

    def get_pointer_to_function(self, _name: str) -> int:
        """None: there is no machine code."""
        return 0

    @property
    def codegen(self) -> Any:
        """In place of the code generator, which would look for `set_env` in machine code."""
        return self

    def set_env(self, name: str, env: Any) -> None:
        """Remember what the function makes Python objects with, as for `print`."""
        self.env = name, env


class LoopLibrary(JITCodeLibrary):
    """What is made of a function that Python calls: machine code, all that it calls inlined."""

    add_llvm_module = take_in

    def finalize(self) -> None:
        """Take in all that it calls, optimise once and make machine code."""
        self._raise_if_finalized()
        callees = reached_libraries(self)
        for callee in callees:
            self._final_module.link_in(module_of(callee), preserve=True)
        self._final_module = optimise(self._final_module, self._codegen)
        self._final_module.verify()
        self._finalize_final_module()
        variable_names = {variable.name for variable in self._final_module.global_variables}
        for callee in callees:
            if isinstance(callee, PartLibrary) and callee.env[0] in variable_names:
                self._codegen.set_env(*callee.env)  # type: ignore[attr-defined]

    def serialize_using_object_code(self) -> tuple:
        """What is kept on disk: the machine code, without the LLVM code that numba puts beside it.

        That is four fifths of a kernel, for functions that would inline it: none calls a loop.
        """
        name, kind, (machine_code, _) = super().serialize_using_object_code()
        return name, kind, (machine_code, names_alone(self._final_module).as_bitcode())


def names_alone(module: Any) -> Any:
    """A module that defines the same names, by which numba knows what is in machine code."""
    functions = [one.name for one in module.functions if not one.is_declaration]
    variables = [one.name for one in module.global_variables if not one.is_declaration]
    lines = [f'define void @"{name}"() {{ ret void }}' for name in functions]
    lines += [f'@"{name}" = global i8 0' for name in variables]
    return parse_assembly("\n".join(lines))


class IrReady(Exception):
    """A function's LLVM code is there, and nothing more is to be made of it."""

    def __init__(self, text: str):
        super().__init__("its LLVM code is there")
        self.text = text


class IrLibrary(JITCodeLibrary):
    """The LLVM code of a function with all that it calls, before anything depends on this CPU."""

    add_llvm_module = take_in

    def finalize(self) -> None:
        """Take in all that it calls, and go no further. Raises IrReady."""
        for callee in reached_libraries(self):
            self._final_module.link_in(module_of(callee), preserve=True)
        raise IrReady(str(self._final_module))


def reached_libraries(library: CPUCodeLibrary) -> list[CPUCodeLibrary]:
    """All that a library calls, callers first: what nobody calls is not taken in."""
    libraries: dict[CPUCodeLibrary, None] = {}

    def visit(at: CPUCodeLibrary) -> None:
        for callee in at._linking_libraries:
            if callee not in libraries:
                if isinstance(callee, PartLibrary):
                    visit(callee)
                libraries[callee] = None

    visit(library)
    return list(reversed(libraries))


def module_of(library: CPUCodeLibrary) -> Any:
    """What is taken in of a library; of one that numba made in its own way, all that it calls."""
    return (
        library.own_module
        if isinstance(library, PartLibrary)
        else library._get_module_for_linking()
    )


def compiler_into(library_class: type[CPUCodeLibrary]) -> type[Compiler]:
    """A compiler of numba whose functions become such libraries."""

    class LibraryCompiler(Compiler):
        def compile_extra(self, func: Callable) -> Any:
            state = self.state
            state.library = library_class(state.targetctx.codegen(), func.__qualname__)
            state.library.enable_object_caching()
            return super().compile_extra(func)

    return LibraryCompiler


if numba.__version__.startswith(TRIED):
    PARTS, LOOPS = compiler_into(PartLibrary), compiler_into(LoopLibrary)
    IR = compiler_into(IrLibrary)
else:
    PARTS = LOOPS = IR = Compiler
