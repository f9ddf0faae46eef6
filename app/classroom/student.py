"""A student of a class: who, in what role, with which flock."""

from __future__ import annotations

import asyncio
import re
import time
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum

from app.classroom.lesson_prediction import LessonPrediction
from app.classroom.workers.page_worker import StudentPage
from app.classroom.workers.worker_process import WorkerProcess
from worlds.input_error import InputError, shorten

# What students may be called: text that a page, a table and a file can show as it is.

MOST_LETTERS = 30
"""Characters of a name."""
MOST_GIVEN = 500
"""Characters that are looked at: blanks are among what is sent, and marks that are joined."""
MOST_MARKS = 2
"""Combining marks in a row: more would tower over other lines."""
MOST_ALIKE = 1000
"""Students of one name that get a number each."""
FORMULA = "=+-@"
"""What a spreadsheet takes for the beginning of a formula."""
BLANK = ("Zs", "Zl", "Zp")
HIDDEN = ("Cc", "Cf", "Cs", "Co", "Cn")
"""Categories of control and format characters, bidirectional ones too, and of no character."""
INVISIBLE = frozenset("\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0")
"""Letters and signs without ink: Hangul fillers, vowels that Khmer implies, Braille's blank."""


def student_name(text: object) -> str:
    """A name as it is shown: 1 to 30 characters in NFC, on one line, blanks single. Raises
    InputError.

    >>> student_name("  Ada   Lovelace "), student_name("Zoe\\u0308")
    ('Ada Lovelace', 'Zoë')
    """
    if not isinstance(text, str) or len(text) > MOST_GIVEN:
        raise InputError(f"name = {shorten(text)} is not allowed: {describe_name_rules()}")
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise name_error(text, "half of a character is in it") from None
    blank = "".join(" " if unicodedata.category(one) in BLANK else one for one in text)
    name = " ".join(unicodedata.normalize("NFC", blank).split(" ")).strip()
    name = re.sub(" +", " ", name)
    if not 1 <= len(name) <= MOST_LETTERS:
        raise name_error(text, describe_name_rules())
    for one in name:
        if unicodedata.category(one) in HIDDEN or one in INVISIBLE:
            raise name_error(text, f"U+{ord(one):04X} in it is no character that can be seen")
    if is_mark(name[0]) or not any(map(is_letter, name)):
        raise name_error(text, "a letter or a figure is needed")
    if any(all(map(is_mark, name[k : k + MOST_MARKS + 1])) for k in range(len(name) - MOST_MARKS)):
        raise name_error(text, f"at most {MOST_MARKS} marks are set on a letter")
    if unicodedata.normalize("NFKC", name)[0] in FORMULA:
        raise name_error(text, "it begins as a formula of a spreadsheet does")
    return name


def describe_name_rules() -> str:
    """How long a name may be, in words."""
    return f"1 to {MOST_LETTERS} characters are needed"


def name_error(text: str, why: str) -> InputError:
    """The refusal of a name, which shows nothing of it that cannot be shown."""
    return InputError(f"name = {text[:MOST_LETTERS]!a} is not allowed: {why}")


def is_mark(one: str) -> bool:
    """Whether a character is set on the one before it."""
    return unicodedata.category(one).startswith("M")


def is_letter(one: str) -> bool:
    """Whether a character is a letter or a figure of any script."""
    return unicodedata.category(one)[0] in "LN"


def same(name: str) -> str:
    """What two names have in common that only differ by case or by how they are written.

    >>> same("ADA") == same("ada"), same("Ａｄａ") == same("ada")
    (True, True)
    """
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())


def unique_name(name: str, taken: Iterable[str]) -> str:
    """A checked name with the first number behind it that makes it one of its own. Raises
    InputError.

    >>> unique_name("Ada", ["ada", "Ada 2"])
    'Ada 3'
    """
    there = {same(one) for one in taken}
    if same(name) not in there:
        return name
    for number in range(2, MOST_ALIKE + 1):
        behind = f" {number}"
        found = name[: MOST_LETTERS - len(behind)].rstrip() + behind
        if same(found) not in there:
            return found
    raise InputError(f"name = {name!r} is not allowed: there are {MOST_ALIKE} of that name")


class Role(StrEnum):
    """What a student does."""

    WATCHING = "watching"
    """The teacher's run, with a camera of one's own and nothing that changes it."""
    OWN = "own"
    """A flock of one's own, from the teacher's scene."""


@dataclass(frozen=True)
class LaboratoryAddress:
    """Where a laboratory is."""

    worker: WorkerProcess
    address: str
    """Where the front finds it, with the secret of its process."""


@dataclass
class Student:
    """One student. `key` is the hash of their cookie; the cookie itself is kept nowhere."""

    number: int
    name: str
    key: str
    role: Role
    scene: str = ""
    """What their own flock ran when it was last looked at, TOML; empty: they have had none."""
    frozen: bool = False
    """Whether their flock is held by the teacher: nothing but their camera is heard."""
    value: float | None = None
    """What the question has given them to try."""
    kind: str = ""
    """The kind of agents that they play in their flock; empty: all."""
    predictions: dict[int, LessonPrediction] = field(default_factory=dict)
    """In the steps of the class's lesson, by the number of the step."""
    place: LaboratoryAddress | None = None
    """Where their own flock is, while it is anywhere."""
    worker: WorkerProcess | None = None
    """The process that has it, or is about to."""
    page: StudentPage | None = None
    """What their browser is given where their flock runs in it, once it is written."""
    begun: int = 0
    """Counts the times that their flock began anew."""
    lines: int = 0
    """Pages that are connected with a laboratory."""
    listening: int = 0
    """Pages with a flock in them that listen to the class."""
    left: float = field(default_factory=time.monotonic)
    """When the last page went, s."""
    came: bool = False
    """Whether a page of theirs was ever connected."""
    moves: int = 0
    """Counts the changes of what their page shows: each has it connect anew."""
    opening: asyncio.Lock = field(default_factory=asyncio.Lock)

    @property
    def is_here(self) -> bool:
        """Whether a page of theirs is connected."""
        return self.lines > 0 or self.listening > 0
