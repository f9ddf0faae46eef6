"""Find models by name: a rule, the body that carries it out, and what they start with.

A new rule is one file in `agents/rules/` and one line in `MODELS` below. Another package adds rules
through the entry-point group `flockscope.rules`, each entry a `Rule` or a `Model`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from agents.bodies import (
    brownian,
    car,
    constant_speed,
    double_integrator,
    drone,
    first_order,
    flyer,
    navigator,
    old_heading,
    point_mass,
    steered,
    swerving,
    turning,
    zero_turn,
)
from agents.bodies.tracking import Tracking
from agents.models.declare import Body, Rule, declared
from agents.models.model import Model
from agents.models.model_calls import declared_functions
from agents.models.rule_file import declaration_in_file
from agents.policies import POLICIES, Policy
from agents.rules import (
    active_brownian,
    boundary_points,
    couzin,
    cucker_smale,
    dorsogna,
    driven,
    echelon,
    gregoire_chate,
    guarded_zones,
    hwvem,
    inertial_spin,
    ivem,
    leadership,
    olfati_saber,
    pedestrian,
    prey_swarm,
    reynolds,
    safe_zones,
    squashing,
    topological,
    tracked,
    vasarhelyi,
    vicsek,
    vicsek1995,
    wvem,
    zones,
)
from worlds.input_error import InputError, shorten, unknown
from worlds.notebook_html import table
from worlds.plug_ins import plug_ins

CONSTANT = constant_speed.BODY
NEUTRAL = {"heading": CONSTANT, "acceleration": point_mass.BODY}
"""The bodies of rules that come without one, by what they wish."""

LATTICE = ("nearest-neighbour", "groups")
"""What tells of flocks that keep a distance: whether they do, and whether they hang together. At a
goal they stand, and no heading means anything."""
CLOSED_UP = ("groups", "polarisation", "nearest-neighbour")
"""What tells of flocks whose bodies may touch, or be left behind."""
CROWD = ("polarisation", "nearest-neighbour", "groups")
"""What tells of flocks that are to agree and yet keep clear of each other."""
ROUND = ("nearest-neighbour", "angular-momentum")
"""What tells of cars that go round a place together."""

BUILT_IN = [
    Model(vicsek1995.RULE, old_heading.BODY, agents=400, density=4.0),
    Model(gregoire_chate.RULE, CONSTANT, agents=512, density=2.0, defaults={"v0": 0.5}),
    Model(topological.RULE, CONSTANT, agents=400, defaults={"neighbours": "nearest"}),
    Model(vicsek.VEM, CONSTANT),
    Model(vicsek.VEM_A, CONSTANT),
    Model(ivem.IVEM, CONSTANT),
    Model(ivem.IVEM_A, CONSTANT),
    Model(wvem.WVEM, CONSTANT),
    Model(hwvem.HWVEM, CONSTANT),
    navigator.model(vicsek.VEM_A),
    navigator.model(ivem.IVEM_A),
    navigator.model(wvem.WVEM),
    navigator.model(hwvem.HWVEM),
    Model(
        olfati_saber.RULE,
        double_integrator.BODY,
        world="wu2023-independent",
        agents=30,
        tells=LATTICE,
    ),
    Model(
        boundary_points.RULE, double_integrator.BODY, world="wu2023-multi", agents=30, tells=LATTICE
    ),
    Model(reynolds.REYNOLDS, steered.BODY, world="obstacles", agents=80, tells=CROWD),
    Model(vasarhelyi.VASARHELYI, drone.BODY, world="drone-arena", agents=30, tells=CROWD),
    drone.scale_to_tenth(vasarhelyi.VASARHELYI, tells=CROWD),
    Model(
        pedestrian.RULE,
        point_mass.BODY,
        world="walkway",
        agents=60,
        spacing=0.4,
        defaults={"dt": 0.05},
        tells=("lane-order", "nearest-neighbour"),
    ),
    Model(
        cucker_smale.RULE,
        point_mass.BODY,
        world="open",
        defaults={"dt": 0.02, "v_start": 2.0},
        tells=("velocity-spread", "polarisation", "gyration-radius"),
    ),
    Model(
        dorsogna.RULE,
        point_mass.BODY,
        world="open",
        dim=2,
        defaults={"dt": 0.02, "v_start": 1.0},
        tells=("angular-momentum", "polarisation", "gyration-radius", "velocity-spread"),
    ),
    Model(
        prey_swarm.RULE,
        first_order.BODY,
        world="open",
        tells=("gyration-radius", "nearest-neighbour"),
    ),
    Model(
        active_brownian.RULE,
        brownian.BODY,
        world="meadow",
        dim=2,
        agents=1000,
        tells=("largest-group", "mean-neighbours", "polarisation"),
    ),
    Model(couzin.COUZIN, turning.BODY, world="meadow", dim=3),
    Model(
        leadership.RULE,
        turning.BODY,
        world="open",
        agents=50,
        density=0.44,
        defaults={"s": 1.0, "theta": 114.59, "tau": 0.2},
        tells=("polarisation", "groups", "gyration-radius"),
    ),
    Model(inertial_spin.RULE, swerving.BODY, agents=400),
    Model(
        zones.ZONES,
        flyer.FLYER,
        world="thesis-sky",
        agents=50,
        defaults={"contact": "start", "d_0": 2.0},
        tells=CLOSED_UP,
    ),
    Model(safe_zones.SAFE, flyer.FLYER, world="thesis-sky", agents=50, tells=CLOSED_UP),
    Model(
        guarded_zones.GUARDED,
        flyer.FLYER,
        world="thesis-blocks",
        agents=50,
        spacing=1.5,
        defaults={"v0": 1.0, "v_min": 0.5, "v_max": 1.5},
        tells=CLOSED_UP,
    ),
    Model(
        echelon.ECHELON,
        flyer.FLYER,
        world="high-sky",
        dim=3,
        agents=30,
        spacing=3.0,
        defaults={"v0": 3.5, "v_min": 3.0, "v_max": 5.0, "body": 0.5, "b": 2.5},
        tells=("drag-saved", "energy-saved", "polarisation", "groups"),
    ),
    Model(
        squashing.SQUASHING,
        zero_turn.BODY,
        world="cars-circle",
        agents=4,
        defaults={"noise_xy": 0.0, "noise_yaw": 0.0},
        tells=ROUND,
    ),
    car.driving(
        squashing.SQUASHING,
        world="cars-circle",
        agents=4,
        tells=ROUND,
        tries=driven.OF_SQUASHING,
    ),
    Model(
        squashing.SQUASHING,
        car.BODY,
        suffix="-best",
        title_suffix=", driven by cars that yield",
        summary_suffix=" Here cars hear the two nearest only, and look ahead: they brake, swerve "
        "or back out rather than touch another.",
        world="cars-circle",
        agents=4,
        defaults={"k": 2.0, "yields": True},
        tells=ROUND,
        tries=driven.OF_SQUASHING,
    ),
    car.driving(
        couzin.COUZIN,
        world="cars-torus",
        agents=12,
        spacing=0.6,
        defaults={"r_r": 0.8, "dr_o": 2.0, "dr_a": 3.2, "yields": True},
        tries=driven.OF_COUZIN,
    ),
    car.driving(
        hwvem.HWVEM,
        world="cars-torus",
        agents=12,
        spacing=0.6,
        defaults={"r": 4.0, "yields": True},
        tries=driven.OF_HWVEM,
    ),
]


TRACKED = (
    "polarisation", "angular-momentum", "divergence", "number-seen", "nearest-neighbour"
)  # fmt: skip
"""What tells of tracks: how ordered and how dense those seen are, and how many are seen."""
PLAYED = {
    rule.name: Model(rule, tracked.BODY, world="open", tells=TRACKED)
    for rule in (tracked.METRES, tracked.PIXELS, tracked.LENGTHS)
}
"""Models of what is played and not run, by name: found by it, and offered nowhere."""


def short_model_name(name: str) -> str:
    """What a model is called in a table: tracks are tracks, whatever their unit.

    >>> short_model_name("tracks-px"), short_model_name("vem")
    ('tracks', 'vem')
    """
    return tracked.METRES.name if name in PLAYED else name


class ModelCatalogue(dict[str, Model]):
    """Models by name, which a notebook shows as a table. Those that are `PLAYED` answer to their
    names too, and are not among them."""

    def __missing__(self, name: str) -> Model:
        return PLAYED[name]

    def __repr__(self) -> str:
        return f"<{len(self)} models: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        return table({name: f"{one.title}. {one.summary}" for name, one in self.items()}, "Models")


def collect() -> ModelCatalogue:
    """All models: the built-in ones, then those of other packages, which replace none of these.

    Warns of what cannot be loaded.
    """
    models = {model.name: model for model in BUILT_IN}
    return ModelCatalogue(models | plug_ins("flockscope.rules", model_of_entry, models))


def body_of_entry(_: str, entry: object) -> tuple[str, Body]:
    """The body that an entry point brings. Raises TypeError if it is none."""
    if not isinstance(entry, Body):
        raise TypeError(f"a Body is needed, not {type(entry).__name__}")
    declared(entry.parameters)
    return entry.name, entry


def model_of_entry(_: str, entry: object) -> tuple[str, Model]:
    """The model that an entry point brings. Raises TypeError if it is none, or no rule."""
    if not isinstance(entry, Rule | Model):
        raise TypeError(f"a Rule or a Model is needed, not {type(entry).__name__}")
    model = Model(entry, NEUTRAL.get(entry.wish, CONSTANT)) if isinstance(entry, Rule) else entry
    declared(model.parameters)
    return model.name, model


BODIES = {built_in_body.name: built_in_body for built_in_body in (CONSTANT, point_mass.BODY)}
BODIES |= plug_ins("flockscope.bodies", body_of_entry, BODIES)
"""Bodies that any rule may have, if it wishes what they take: `RULE-BODY` is such a model."""

ON_WHEELS = "-cars"
"""Behind the name of a rule: the model of cars that go by it."""

MODELS = collect()
FILES: dict[str, Path] = {}
"""The files that models were read from, by their names; those of policies by `policy NAME`."""


def from_file(path: str) -> Model | Policy:
    """Load the model of a rule file, or a policy, and add it to the catalogue. Raises InputError.

    An edited file replaces what it brought before; none replaces what is of anything else.
    """
    declaration = declaration_in_file(path)
    if isinstance(declaration, Policy):
        return take_policy(path, declaration)
    try:
        name, loaded_model = model_of_entry(path, declaration)
    except (TypeError, AssertionError) as error:
        raise InputError(f"{path}: {error}") from None
    if name in MODELS and FILES.get(name) != Path(path).resolve():
        raise InputError(f"{path}: there is a model {name!r} already; its rule needs another name")
    if name not in MODELS or loaded_model.rule is not MODELS[name].rule:
        take_over(name, loaded_model)
        FILES[name] = Path(path).resolve()
    return MODELS[name]


def take_policy(path: str, declared_policy: Policy) -> Policy:
    """Add a policy to the catalogue. Raises InputError if another file has one of its name."""
    name = declared_policy.name
    key = f"policy {name}"
    if name in POLICIES and FILES.get(key) != Path(path).resolve():
        raise InputError(f"{path}: there is a policy {name!r} already; it needs another name")
    if name not in POLICIES or POLICIES[name].digest != declared_policy.digest:
        POLICIES[name], FILES[key] = declared_policy, Path(path).resolve()
    return POLICIES[name]


def take_over(name: str, taken: Model) -> None:
    """Put a model in the place of the one of that name, whose rule no other model has from now on:
    `NAME-cars` is made anew when it is asked for."""
    before = MODELS.get(name)
    for other in [one for one in MODELS if before is not None and MODELS[one].rule is before.rule]:
        del MODELS[other]
    MODELS[name] = taken


def model(name: str) -> Model:
    """The model of that name; `NAME-cars` has the rule of the model NAME drive cars.

    So `NAME-BODY` is that rule with one of `BODIES`. Raises InputError with the nearest name, or
    for a rule that cannot drive cars. A name is never that of a file, which would be run: names
    come from browsers and from specs of others too.
    """
    if name in PLAYED:
        return PLAYED[name]
    rule = name.removesuffix(ON_WHEELS)
    if name not in MODELS and rule != name and rule in MODELS and MODELS[rule].rule.name == rule:
        MODELS[name] = drive_on_wheels(MODELS[rule].rule)
    if name not in MODELS:
        add_model_with_body(name)
    if name not in MODELS:
        alike = [one for one in MODELS if str(name).lower() in MODELS[one].rule.tags]
        if alike:
            raise InputError(
                f"unknown model {shorten(name)}: did you mean {' or '.join(alike[:3])}?"
            )
        raise unknown("model", name, MODELS)
    return MODELS[name]


def is_built_in(name: str) -> bool:
    """Whether all code of a model is flockscope's own. Raises InputError for a model that is none.

    >>> is_built_in("vem")
    True
    """
    named = model(name)
    home = __name__.rpartition(".")[0] + "."
    return all(
        function.py_func.__module__.startswith(home)
        for part, kind in ((named.rule, "rule"), (named.body, "body"))
        for _, function in declared_functions(part, kind)
    )


def add_model_with_body(name: str) -> None:
    """Add the model `RULE-BODY` to the catalogue if both exist. Raises InputError."""
    for body in BODIES.values():
        rule = name.removesuffix(f"-{body.name}")
        if rule != name and rule in MODELS and MODELS[rule].rule.name == rule:
            own = MODELS[rule]
            try:
                MODELS[name] = replace(
                    own, body=body, suffix=f"-{body.name}", defaults={}, tries=()
                )
            except TypeError as error:
                raise InputError(str(error)) from None


def drive_on_wheels(rule: Rule) -> Model:
    """The model of cars driven by a rule, on an unbounded floor. Raises InputError if it cannot be.

    Cars of another rule that wishes a velocity are declared one by one: it may need its own body.
    """
    if rule.wish != "heading" or 2 not in rule.dimensions:
        raise InputError(
            f"{rule.name} cannot drive cars: it wishes {rule.wish} in "
            f"{' and '.join(f'{dim}-D' for dim in rule.dimensions)}, they take a heading in 2-D"
        )
    return car.driving(rule, world="cars-torus", agents=12, spacing=0.6, defaults={"yields": True})


def obedient_car_models() -> tuple[str, ...]:
    """The models of cars whose commands real cars can obey."""
    return tuple(
        name
        for name, body_model in MODELS.items()
        if body_model.body.vehicle is not None and body_model.body.vehicle.wheel
    )


def cars_for_rule(name: str) -> Model:
    """The cars that go by a rule: a model of cars, or the rule of another one. Raises
    InputError."""
    models = obedient_car_models()
    if name in models:
        return MODELS[name]
    rules: dict[str, Rule] = {}
    for key, model in MODELS.items():
        rules |= {model.rule.name: model.rule, key: model.rule}
    if name not in rules:
        raise unknown("rule", name, dict.fromkeys([*models, *rules]), "the laboratory")
    rule = rules[name]
    if rule.name + ON_WHEELS in MODELS:
        return MODELS[rule.name + ON_WHEELS]
    if 2 not in rule.dimensions or rule.wish not in ("heading", "velocity"):
        raise InputError(
            f"rule {name} cannot drive cars: it wishes {rule.wish} in "
            f"{' and '.join(f'{d}-D' for d in rule.dimensions)}, and cars take a heading or a "
            "velocity in 2-D"
        )
    shared_names = set(rule.parameters.model_fields) & set(car.Car.model_fields)
    if shared_names and not issubclass(rule.parameters, Tracking):
        raise InputError(
            f"rule {name} cannot drive cars: it has a parameter {sorted(shared_names)[0]} of its "
            "own, and so have they"
        )
    return car.driving(rule)
