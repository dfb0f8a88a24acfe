"""A console for texts of people, files and logs: nothing in them is markup or moves a cursor; pipes get whole lines."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from firmware_py.foreign_text import visible

_UNBOUNDED = 10_000
"""Columns of what is no terminal: nobody can widen a file or a pipe."""


class PlainConsole(Console):
    """A console that shows texts as they are; what is to have a style is a `Text`.

    Where it is no terminal, no line is wrapped to a width that nobody has, nor filled up with blanks.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, **options)
        if "width" not in options and not self.is_terminal:
            self.width = _UNBOUNDED

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text to be shown, with every character in it visible."""
        return super().render_str("\n".join(map(visible, text.split("\n"))), **options)

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as `rich` does; without blanks at the ends of lines where it is no terminal."""
        if self.is_terminal:
            super().print(*objects, **options)
            return
        with self.capture() as made:
            super().print(*objects, **options)
        whole = "\n".join(line.rstrip(" ") for line in made.get().split("\n"))
        super().print(Text(whole), end="", soft_wrap=True)  # so that a capture around it catches it
