"""What there is to try with cars, by the rule that drives them."""

from __future__ import annotations

from agents.models.tries import LessonCheck, LessonStep

OF_SQUASHING = (
    LessonStep(
        "Have cars look ahead, and keep 0.3 m from each other.",
        "Nobody touches: cars keep well apart, and the group is wider.",
        {"yields": True, "margin": 0.3},
        LessonCheck("nearest-neighbour", "above", 0.48, 1500),
        anew=True,
    ),
    LessonStep(
        "Give cars that look ahead a turning circle of 3 m.",
        "They cannot turn as tightly as the injected car goes round, and swing far out.",
        {"yields": True, "circle": 3.0},
        LessonCheck("gyration-radius", "above", 0.6, 1500),
        anew=True,
    ),
    LessonStep(
        "Take the injected car's weight away, and have cars look ahead.",
        "With nobody to follow they stay together and drive about one another.",
        {"yields": True, "c_goal": 0.0},
        LessonCheck("gyration-radius", "above", 0.4, 1500),
        anew=True,
    ),
)

OF_COUZIN = (
    LessonStep(
        "Lose all commands.",
        "Every car goes on with the last command that it got, in a circle of its own, and the "
        "order is lost.",
        {"loss": 1.0},
        LessonCheck("polarisation", "below", 0.6, 1500),
    ),
    LessonStep(
        "Take the zone of orientation away.",
        "A knot of cars that go nowhere in particular, with every heading among them.",
        {"dr_o": 0.0},
        LessonCheck("polarisation", "below", 0.5, 1500),
    ),
    LessonStep(
        "Widen the zone of repulsion to 2.",
        "Cars spread out: nobody has another within a metre.",
        {"r_r": 2.0},
        LessonCheck("nearest-neighbour", "above", 0.95, 1500),
    ),
)

OF_HWVEM = (
    LessonStep(
        "Let cars notice each other only within 1 m.",
        "Most hear nobody and drive on as they began: a dozen groups, and no common heading.",
        {"r": 1.0},
        LessonCheck("polarisation", "below", 0.8, 1500),
        anew=True,
    ),
    LessonStep(
        "Raise the noise to 6 rad.",
        "Every car weaves about, and yet they get on in one direction: their bodies are too "
        "slow for so much noise.",
        {"eta": 6.0},
        LessonCheck("velocity-spread", "above", 0.2, 1500),
    ),
    LessonStep(
        "Lose all commands.",
        "Every car keeps the last command that it got, and small differences take them apart "
        "bit by bit.",
        {"loss": 1.0},
        LessonCheck("velocity-spread", "above", 0.05, 1500),
    ),
)
