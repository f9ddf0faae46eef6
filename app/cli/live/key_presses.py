"""Keys pressed in the terminal, one by one, without waiting for the end of a line."""

from __future__ import annotations

import os
import select
import sys
import time
from typing import Any


class Keys:
    """While entered, `pressed` gives the keys; where there is no terminal there are none."""

    def __init__(self) -> None:
        self.before: Any = None
        self.fileno = -1

    @property
    def there(self) -> bool:
        """Whether keys can come."""
        return self.fileno >= 0

    def __enter__(self) -> Keys:
        try:
            import termios
            import tty

            fileno = sys.stdin.fileno()
            if os.isatty(fileno) and os.tcgetpgrp(fileno) == os.getpgrp():
                self.before = termios.tcgetattr(fileno)
                tty.setcbreak(fileno)
                self.fileno = fileno
        except (ImportError, OSError, ValueError):
            self.fileno = -1
        return self

    def __exit__(self, *_: object) -> None:
        if self.there:
            import termios

            termios.tcsetattr(self.fileno, termios.TCSADRAIN, self.before)
            self.fileno = -1

    def pressed(self, within: float) -> str:
        """The keys pressed, "" if there are none within so many seconds."""
        if not self.there:
            time.sleep(within)
            return ""
        if not select.select([self.fileno], [], [], within)[0]:
            return ""
        data = os.read(self.fileno, 64)
        if not data:  # the terminal is gone
            self.fileno = -1
        return data.decode(errors="replace")
