"""A terminal that is written to with texts of people, files and logs: nothing in them is markup or moves its cursor."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from firmware_py.foreign_text import visible


class PlainConsole(Console):
    """A console that shows texts as they are; what is to have a style is a `Text`."""

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text to be shown, with every character in it visible."""
        return super().render_str("\n".join(map(visible, text.split("\n"))), **options)
