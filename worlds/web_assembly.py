"""Makes WebAssembly of compiled functions, from the same LLVM code that becomes machine code here.

llvmlite brings LLVM's WebAssembly back end; no linker is needed. The object that it emits is a
valid module but for the names by which it is called, which `with_exports` adds.

Every function becomes one that takes the address of a block: its arguments, 8 bytes each, in the
order of the call, arrays and tuples flattened (see `MemoryImage`). It imports its memory
(`env.__linear_memory`) from whoever runs it: the stack grows down from 1 MiB, so data begin at
`FIRST_FREE`.
"""

from __future__ import annotations

import functools
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np

from worlds.code_libraries import TRIED, IrReady
from worlds.compilation import ir_dispatcher
from worlds.input_error import InputError
from worlds.web_binary import with_exports

TRIPLE = "wasm32-unknown-unknown"
FEATURES = "+simd128,+bulk-memory,+sign-ext,+nontrapping-fptoint,+mutable-globals"
"""What all browsers of the last years have. Not relaxed-simd: its results differ by machine."""
FIRST_FREE = 2 * 1024 * 1024
"""Address from which on memory is free: below it are the module's own data and the stack."""
SLOT = 8
"""Bytes of an argument in a block."""
FREXP = """
define double @numba_frexp(double %x, ptr %exponent) {
  %bits = bitcast double %x to i64
  %high = lshr i64 %bits, 52
  %biased = and i64 %high, 2047
  %is_zero = fcmp oeq double %x, 0.0
  %is_huge = icmp eq i64 %biased, 2047
  %plain = or i1 %is_zero, %is_huge
  %is_small = icmp eq i64 %biased, 0
  %scaled = fmul double %x, 0x4350000000000000
  %scaled_bits = bitcast double %scaled to i64
  %from = select i1 %is_small, i64 %scaled_bits, i64 %bits
  %from_high = lshr i64 %from, 52
  %from_biased = and i64 %from_high, 2047
  %cleared = and i64 %from, -9218868437227405313
  %mantissa_bits = or i64 %cleared, 4602678819172646912
  %mantissa = bitcast i64 %mantissa_bits to double
  %offset = select i1 %is_small, i64 -1076, i64 -1022
  %e64 = add i64 %from_biased, %offset
  %e32 = trunc i64 %e64 to i32
  %e = select i1 %plain, i32 0, i32 %e32
  store i32 %e, ptr %exponent
  %result = select i1 %plain, double %x, double %mantissa
  ret double %result
}
"""
LDEXP = """
define double @numba_ldexp(double %x, i32 %exponent) {
  %is_small = icmp slt i32 %exponent, -2000
  %least = select i1 %is_small, i32 -2000, i32 %exponent
  %is_large = icmp sgt i32 %least, 2000
  %e = select i1 %is_large, i32 2000, i32 %least
  %half = ashr i32 %e, 1
  %rest = sub i32 %e, %half
  %half_biased = add i32 %half, 1023
  %rest_biased = add i32 %rest, 1023
  %half_long = zext i32 %half_biased to i64
  %rest_long = zext i32 %rest_biased to i64
  %half_bits = shl i64 %half_long, 52
  %rest_bits = shl i64 %rest_long, 52
  %half_power = bitcast i64 %half_bits to double
  %rest_power = bitcast i64 %rest_bits to double
  %scaled = fmul double %x, %half_power
  %result = fmul double %scaled, %rest_power
  ret double %result
}
"""
OF_NUMBA = {"numba_frexp": FREXP, "numba_ldexp": LDEXP}
"""Functions of numba's own library, so that a page need not bring them."""


@dataclass(frozen=True)
class LinkedCode:
    """A function with all that it calls, as LLVM code that is not optimised yet."""

    name: str
    """Its name in Python, by which its symbol is found."""
    text: str


def linked_code(
    function: Callable, arguments: Sequence[object], takes_text: bool = False
) -> LinkedCode:
    """The LLVM code of a compiled function for arguments such as these.

    `function` is made by `compilation.entry` or `compilation.compiled`. `takes_text`: it reads
    attributes by `getattr` with a name (see `compilation.compiled`). Raises InputError with a
    version of numba that this was not tried with.
    """
    if not numba.__version__.startswith(TRIED):
        tried = " or ".join(f"{version}x" for version in TRIED)
        raise InputError(f"numba {numba.__version__} is not supported here: {tried} is needed")
    python = getattr(function, "py_func", function)
    return code_of(python, tuple(numba.typeof(value) for value in arguments), takes_text)


@functools.lru_cache(maxsize=24)  # some of them are megabytes
def code_of(python: Callable, kinds: tuple[Any, ...], takes_text: bool) -> LinkedCode:
    """The LLVM code of a function for arguments of some of numba's types."""
    try:
        ir_dispatcher(python, takes_text).compile(kinds)
    except IrReady as ready:
        return LinkedCode(python.__name__, ready.text)
    raise AssertionError(f"{python.__name__} was compiled without its LLVM code")


@dataclass
class Argument:
    """A number or an array among the arguments of a function, and where it stands."""

    slot: int
    """Number of its slot in the block; of an array that of its first."""
    kind: str
    """`int64` or another name of NumPy's, of an array that of its items."""
    address: int = 0
    """Of an array, where its items stand; 0 of a number."""
    shape: tuple[int, ...] = ()


class MemoryImage:
    """The memory of a module as a call finds it: arrays, what is answered, the block of arguments.

    Arrays stand on 64 bytes, each once; one that is empty has room all the same. After `finish`,
    `content` stands at `FIRST_FREE`, and `block` is the address that the function is called with.
    """

    ALIGNED = 64
    ANSWER, EXCEPTION = 256, 64
    """Bytes for what a function returns, and for an exception of numba's."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.slots: list[tuple[str, int | float]] = []
        self.arguments: dict[str, Argument] = {}
        """By path, as `context.parameters.eta`."""
        self.known: dict[tuple[int, tuple[int, ...], str], int] = {}
        self.answer = self.allot(bytes(self.ANSWER))
        self.slots += [("p", self.answer), ("p", self.allot(bytes(self.EXCEPTION)))]
        self.block = 0

    def allot(self, content: bytes) -> int:
        """Room for these bytes; its address."""
        self.content.extend(bytes(-len(self.content) % self.ALIGNED))
        address = FIRST_FREE + len(self.content)
        self.content.extend(content)
        return address

    def add(self, path: str, value: object) -> None:
        """Add an argument; the members of a tuple by their names, or by their numbers.

        Kinds of slots: `p` an address, `l` int64, `d` double, `b` a byte. An array of d axes takes
        5 + 2 d slots.
        """
        if isinstance(value, np.ndarray):
            self.add_array(path, value)
        elif isinstance(value, tuple):
            names = getattr(value, "_fields", range(len(value)))
            for name, member in zip(names, value, strict=True):
                self.add(f"{path}.{name}", member)
        elif isinstance(value, bool | np.bool_):
            self.add_number(path, "b", "bool", int(value))
        elif isinstance(value, int | np.integer):
            self.add_number(path, "l", "int64", int(value))
        elif isinstance(value, float | np.floating):
            self.add_number(path, "d", "float64", float(value))
        else:
            raise TypeError(f"{path} is {type(value).__name__}: no argument of a compiled function")

    def add_number(self, path: str, slot: str, kind: str, value: int | float) -> None:
        """Add a number."""
        self.arguments[path] = Argument(len(self.slots), kind)
        self.slots.append((slot, value))

    def add_array(self, path: str, array: np.ndarray) -> None:
        """Add an array, which has to be in C order."""
        if not array.flags.c_contiguous:
            raise ValueError(f"{path} is not in C order")
        key = array.ctypes.data, array.shape, str(array.dtype)
        address = self.known.get(key) if array.size else None
        if address is None:
            address = self.allot(array.tobytes() or bytes(SLOT))
            self.known[key] = address
        self.arguments[path] = Argument(
            len(self.slots), str(array.dtype), address, tuple(array.shape)
        )
        self.slots += [("p", 0), ("p", 0), ("l", array.size), ("l", array.itemsize), ("p", address)]
        self.slots += [("l", number) for number in (*array.shape, *array.strides)]

    def finish(self) -> None:
        """Add the block of all arguments."""
        packing = {"p": "<I4x", "l": "<q", "d": "<d", "b": "<B7x"}
        block = b"".join(struct.pack(packing[kind], value) for kind, value in self.slots)
        self.block = self.allot(block)


KINDS = {"ptr": "p", "i64": "l", "double": "d", "i1": "b", "i8": "b"}
"""LLVM's types of arguments as kinds of slots."""


@dataclass(frozen=True)
class WebModule:
    """A module of WebAssembly."""

    content: bytes
    slots: dict[str, tuple[str, ...]]
    """Of each function that it exports, the kinds of its slots: first the address of its answer
    and that of an exception, then its arguments."""


def web_module(
    functions: dict[str, LinkedCode], own: Mapping[str, Callable[[], LinkedCode]] | None = None
) -> WebModule:
    """One module that exports these functions by their keys; a page calls `key(block)`.

    It answers 0, or another number where numba would raise an exception. `own`: what makes the code
    of functions of doubles that are taken in place of a library's of the same names.
    """
    machine = target_machine()
    whole, slots = None, {}
    own = own or {}
    needed: set[str] = set()
    for name, code in functions.items():
        text, names = with_own(code.text, own)
        needed |= names
        module = for_the_web(text, machine)
        symbol = entry_symbol(module, code.name)
        kinds = [str(argument.type) for argument in module.get_function(symbol).arguments]
        slots[name] = tuple(KINDS[kind] for kind in kinds)
        hide_all_but(module, symbol)
        module.link_in(parsed(block_caller(symbol, kinds, name), machine))
        link_helpers(module, machine)
        hide_all_but(module, name)
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    if whole is None:
        raise ValueError("a module needs a function")
    called = {function.name for function in whole.functions}
    for name in sorted(needed):
        if OWN_LANES.format(name) in called:
            whole.link_in(parsed(lanes_caller(name), machine))
            whole.get_function(OWN_LANES.format(name)).linkage = "internal"
    for name in sorted(needed):
        whole.link_in(own_function(name, own[name](), machine))
        whole.get_function(OWN.format(name)).linkage = "internal"
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization = tuning.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(whole, builder)
    return WebModule(with_exports(machine.emit_object(whole), tuple(functions)), slots)


def link_helpers(module: llvm.ModuleRef, machine: llvm.TargetMachine) -> None:
    """Link in what a module calls of numba's own library."""
    called = {function.name for function in module.functions if function.is_declaration}
    for name in called & OF_NUMBA.keys():
        module.link_in(parsed(OF_NUMBA[name], machine))


OWN, OWN_LANES = "own_{}", "own_{}_lanes"
"""What a library's function of a double, or of eight, is called where it is one of ours."""
LANES = 8
"""Doubles of a vector: `agents.engine.vector_lanes.WIDTH`."""


def with_own(text: str, own: Mapping[str, object]) -> tuple[str, set[str]]:
    """LLVM code that calls functions of ours in place of a library's, and which of them."""
    if not own:
        return text, set()
    names = "|".join(own)
    found = set()

    def renamed(match: re.Match[str]) -> str:
        found.add(match[1])
        return f"@{OWN.format(match[1])}("

    text = re.sub(rf"@(?:llvm\.)?({names})(?:\.f64)?\(", renamed, text)

    def renamed_lanes(match: re.Match[str]) -> str:
        found.add(match[1])
        return f"@{OWN_LANES.format(match[1])}("

    text = re.sub(rf"@llvm\.({names})\.v{LANES}f64\(", renamed_lanes, text)
    lines, declared = [], set()
    for line in text.split("\n"):  # the library's and LLVM's own name may both be declared
        match = re.match(r"declare double @(own_\w+)\(", line)
        if match is None or match[1] not in declared:
            lines.append(line)
        if match is not None:
            declared.add(match[1])
    return "\n".join(lines), found


def lanes_caller(name: str) -> str:
    """One of our functions of eight doubles, as LLVM code: it calls that of one double."""
    kind = f"<{LANES} x double>"
    lines = [
        f"declare double @{OWN.format(name)}(double)",
        f"define {kind} @{OWN_LANES.format(name)}({kind} %x) {{",
    ]
    before = "undef"
    for lane in range(LANES):
        lines.append(f"  %x{lane} = extractelement {kind} %x, i32 {lane}")
        lines.append(f"  %y{lane} = call double @{OWN.format(name)}(double %x{lane})")
        lines.append(f"  %v{lane} = insertelement {kind} {before}, double %y{lane}, i32 {lane}")
        before = f"%v{lane}"
    return "\n".join([*lines, f"  ret {kind} {before}", "}", ""])


def own_function(name: str, code: LinkedCode, machine: llvm.TargetMachine) -> llvm.ModuleRef:
    """A function of doubles as C has it, of the compiled one."""
    module = for_the_web(code.text, machine)
    symbol = entry_symbol(module, code.name)
    count = len(list(module.get_function(symbol).arguments)) - 2
    given = ", ".join(f"double %x{k}" for k in range(count))
    caller = "\n".join(
        (
            f'declare i32 @"{symbol}"(ptr, ptr{", double" * count})',
            f"define double @{OWN.format(name)}({given}) noinline {{",
            "  %answer = alloca double",
            "  %raised = alloca ptr",
            f'  %status = call i32 @"{symbol}"(ptr %answer, ptr %raised, {given})',
            "  %value = load double, ptr %answer",
            "  ret double %value",
            "}",
            "",
        )
    )
    hide_all_but(module, symbol)
    module.link_in(parsed(caller, machine))
    link_helpers(module, machine)
    hide_all_but(module, OWN.format(name))
    return module


def target_machine() -> llvm.TargetMachine:
    """The machine that code is made for."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple(TRIPLE).create_target_machine(
        opt=3, features=FEATURES, codemodel="default", reloc="static"
    )


def parsed(text: str, machine: llvm.TargetMachine) -> llvm.ModuleRef:
    """LLVM code as a module for a machine."""
    head = f'target triple = "{TRIPLE}"\ntarget datalayout = "{machine.target_data}"\n'
    return llvm.parse_assembly(head + text)


def for_the_web(text: str, machine: llvm.TargetMachine) -> llvm.ModuleRef:
    """LLVM code of this computer, for a machine: nothing else of it depends on the computer."""
    text = re.sub(r'^target (triple|datalayout) = ".*"$', "", text, flags=re.MULTILINE)
    return parsed(re.sub(r'"target-(cpu|features)"="[^"]*"', "", text), machine)


def entry_symbol(module: llvm.ModuleRef, name: str) -> str:
    """The symbol of a function itself: not of what lets Python or C call it."""
    marker = f"{len(name)}{name}B"
    (symbol,) = (
        function.name
        for function in module.functions
        if not function.is_declaration
        and function.name.startswith("_ZN")
        and marker in function.name
        and not function.name.startswith("_ZN7cpython")
    )
    return symbol


def block_caller(symbol: str, kinds: Sequence[str], name: str) -> str:
    """A function that reads each argument from a slot: a page would else pass hundreds of them,
    and every whole number as a BigInt."""
    lines, values = [], []
    for place, kind in enumerate(kinds):
        stored = "i8" if kind == "i1" else kind
        lines.append(f"  %p{place} = getelementptr i8, ptr %block, i32 {SLOT * place}")
        lines.append(f"  %v{place} = load {stored}, ptr %p{place}, align 8")
        if kind == "i1":
            lines.append(f"  %w{place} = trunc i8 %v{place} to i1")
        values.append(f"{kind} %{'w' if kind == 'i1' else 'v'}{place}")
    return "\n".join(
        (
            f'declare i32 @"{symbol}"({", ".join(kinds)})',
            f"define i32 @{name}(ptr %block) {{",
            *lines,
            f'  %status = call i32 @"{symbol}"({", ".join(values)})',
            "  ret i32 %status",
            "}",
            "",
        )
    )


def hide_all_but(module: llvm.ModuleRef, name: str) -> None:
    """Let nothing of a module be seen but one function: all else is inlined or dropped, also what
    would call Python."""
    for function in module.functions:
        if not function.is_declaration and function.name != name:
            function.linkage = "internal"
    for variable in module.global_variables:
        if not variable.is_declaration and variable.linkage.name != "appending":
            variable.linkage = "internal"
