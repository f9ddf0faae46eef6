"""Commands as Typer makes them, but strict, and with one line for what was typed wrong."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import wraps
from typing import Annotated, Any, NoReturn, get_type_hints

import typer
from typer.core import TyperCommand, TyperGroup

from app.cli.terminal.console import REFUSED, one_line, with_one_line_errors
from worlds.input_error import InputError, nearest, needed, shorten, suggestion

USAGE_ERROR: type[Exception] = typer.BadParameter.__bases__[0]
"""What Typer raises for a wrong command line; Typer itself has no name for it."""

LENGTHS = ("ticks", "steps", "seconds", "time", "duration", "length")
"""Words for how long something lasts."""


class OneCommand(TyperCommand):
    """A command that refuses an option that is given twice, unless it may be repeated."""

    def make_parser(self, ctx: Any) -> Any:
        """The parser, which looks for options given twice."""
        parser = super().make_parser(ctx)
        parse = parser.parse_args

        def parse_once(args: list[str]) -> Any:
            values, rest, order = parse(args)
            for option in order:
                single = not (option.multiple or getattr(option, "is_flag", False))
                if option.param_type_name == "option" and single and order.count(option) > 1:
                    raise RepeatedOption(
                        f"{option.opts[0]} is given {order.count(option)} times", ctx
                    )
            return values, rest, order

        parser.parse_args = parse_once  # type: ignore[method-assign]
        return parser


class RepeatedOption(USAGE_ERROR):  # type: ignore[valid-type,misc]
    """An option that stands twice on the command line."""


class CommandGroup(TyperGroup):
    """Commands by name; what is typed wrong is told in one line."""

    def main(self, *args: Any, **more: Any) -> NoReturn:
        """Run, and leave with the exit code."""
        try:
            code = super().main(*args, **{**more, "standalone_mode": False})
        except USAGE_ERROR as error:
            print_usage_error(error)
            code = REFUSED
        except InputError as refusal:  # of an option, before there is a command
            typer.echo(f"flockscope: {one_line(str(refusal))}", err=True)
            code = REFUSED
        except typer.Abort:
            code = 1
        sys.exit(code if isinstance(code, int) else 0)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is called. Raises what `main` tells for one that there is not."""
        command_names = self.list_commands(ctx)
        if args[0] not in command_names and not args[0].startswith("-"):
            hint = suggestion(args[0], command_names)
            raise USAGE_ERROR(
                f"unknown command {shorten(args[0])}{hint} (known: {', '.join(command_names)})",
                ctx,
            )
        return super().resolve_command(ctx, args)


def with_option_groups(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command with the options of its groups: each parameter that is a dataclass is one.

    Typer knows functions only, so options that several commands share would be repeated in each.
    """
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: kind for name, kind in hints.items() if is_dataclass(kind)}
    signature = inspect.signature(command)
    options: list[inspect.Parameter] = []
    for name, parameter in signature.parameters.items():
        if name not in groups:
            options.append(parameter.replace(kind=parameter.KEYWORD_ONLY, annotation=hints[name]))
            continue
        kinds = get_type_hints(groups[name], include_extras=True)
        options += [
            inspect.Parameter(
                own.name, parameter.KEYWORD_ONLY, default=own.default, annotation=kinds[own.name]
            )
            for own in fields(groups[name])
        ]

    @wraps(command)
    def called(**arguments: Any) -> Any:
        given = {
            name: kind(**{own.name: arguments.pop(own.name) for own in fields(kind)})
            for name, kind in groups.items()
        }
        return command(**given, **arguments)

    called.__signature__ = signature.replace(parameters=options)  # type: ignore[attr-defined]
    return called


def command_group(summary: str, functions: Mapping[str, Callable[..., Any]]) -> typer.Typer:
    """A command that has commands of its own."""
    group = typer.Typer(cls=CommandGroup, help=summary, no_args_is_help=True, add_completion=False)
    for name, function in functions.items():
        group.command(name, cls=OneCommand)(with_one_line_errors(function))
    return group


def print_usage_error(error: Any) -> None:
    """Tell what was typed wrong on stderr."""
    if type(error).__name__ == "NoArgsIsHelpError":
        error.show()
        return
    line = one_line(describe_usage_error(error))
    help_hint = f" ({error.ctx.command_path} --help)" if error.ctx is not None else ""
    typer.echo(f"flockscope: {line}{help_hint}", err=True)


def describe_usage_error(error: Any) -> str:
    """What was typed wrong: the option, its value, what is allowed."""
    if hasattr(error, "possibilities"):
        hint = suggest_option(error.option_name, options_of(error.ctx))
        return f"unknown option {shorten(error.option_name)}{hint}"
    if hasattr(error, "param_type"):
        return f"{parameter_name(error.param)} is missing"
    if getattr(error, "param", None) is not None:
        return wrong_value(error)
    if hasattr(error, "option_name"):
        takes = "needs a value" if "requires" in error.message else "takes no value"
        return f"{error.option_name} {takes}"
    extra = re.fullmatch(r"Got unexpected extra arguments?(?:\(s\))? \((.*)\)", error.message)
    if extra is None:
        return error.message
    hint = "" if error.ctx is None else suggest_assignment(extra[1], options_of(error.ctx))
    return f"unexpected argument {shorten(extra[1])}{hint}"


def options_of(ctx: Any) -> list[str]:
    """The options of a command, as they are typed."""
    names = [name for param in ctx.command.get_params(ctx) for name in param.opts]
    return [name for name in names if name.startswith("-")]


def suggest_option(option: str, options: Sequence[str]) -> str:
    """What an unknown option was most likely meant to be, as a question; "" if nothing is close."""
    name = option.lstrip("-").replace("-", "_")
    length_options = [length for length in ("--ticks", "--seconds") if length in options]
    if name in LENGTHS and length_options:
        return f": did you mean {length_options[0]!r}?"
    suggested = suggestion(option, options)
    if suggested or name in LENGTHS:
        return suggested
    return (
        f": did you mean '--set {name}=...'?" if "--set" in options and is_parameter(name) else ""
    )


def suggest_assignment(text: str, options: Sequence[str]) -> str:
    """How a NAME=VALUE that stands alone is given, as a question; "" if it is none."""
    name, equals, value = text.partition("=")
    option = nearest(f"--{name}", options)
    if not (equals and name and value):
        return ""
    if option and not is_parameter(name):
        return f": did you mean '{option} {value}'?"
    return f": did you mean '--set {text}'?" if "--set" in options else ""


def is_parameter(name: str) -> bool:
    """Whether any model has a parameter of this name."""
    from agents.catalogue import MODELS

    return any(name in model.parameters.model_fields for model in MODELS.values())


def wrong_value(error: Any) -> str:
    """The value of an option or argument that it cannot have."""
    cause = error.__cause__
    if not hasattr(cause, "errors"):
        return f"{parameter_name(error.param)}: {error.message}"
    fault = cause.errors()[0]
    return (
        f"{parameter_name(error.param)} {shorten(fault['input'])} is not allowed: {needed(fault)}"
    )


def parameter_name(param: Any) -> str:
    """An option as it is typed, an argument as the help has it."""
    options: Sequence[str] = param.opts
    return options[0] if options[0].startswith("-") else str(param.name).upper()


# The option `--rule FILE.py`: a rule of one's own, wherever a model's name may stand.


FLYING: list[str] = []
"""The policies that `--rule` has brought on this command line."""


def load_rule_files(files: list[str] | None) -> list[str]:
    """Take the rules and policies of files into the catalogue; the names of the models. Raises
    InputError."""
    FLYING.clear()
    if not files:
        return []
    from agents.catalogue import from_file
    from agents.policies import Policy

    declarations = [from_file(file) for file in files]
    FLYING.extend(one.name for one in declarations if isinstance(one, Policy))
    return [one.name for one in declarations if not isinstance(one, Policy)]


def model_name(model: str | None) -> str | None:
    """The name of a model; a file has its rule taken into the catalogue for it. Raises
    InputError, also for tracks, which follow no rule."""
    if model is not None and model.startswith("tracks"):
        from agents.catalogue import PLAYED

        if model in PLAYED:
            raise InputError(f"{model} is no model to run: `flockscope lab --tracks FILE` plays it")
    if model is None or not model.endswith(".py"):
        return model
    from agents.catalogue import from_file
    from agents.policies import Policy

    declaration = from_file(model)
    if isinstance(declaration, Policy):
        raise InputError(f"{model} has a policy, which is no model: give it by --rule {model}")
    return declaration.name


def first_of(model: str | None, rules: list[str] | None) -> str | None:
    """The model that is asked for: by its name, or else the first of `--rule`."""
    return model or next(iter(rules or ()), None)


# Options that several commands have.

PrintJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No messages while it runs.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Let --out replace a file.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", help="A parameter, NAME=VALUE; may be repeated.")
]
Rules = Annotated[
    list[str] | None,
    typer.Option(
        "--rule",
        callback=load_rule_files,
        is_eager=True,
        metavar="FILE.py",
        help="A Python file with a RULE, a MODEL or a policy of your own; may be repeated.",
    ),
]
Controllers = Annotated[
    list[str] | None,
    typer.Option(
        "--steer",
        metavar="KIND=HOST:PORT",
        help="A controller in another process that steers a kind, by datagrams; may be repeated.",
    ),
]
