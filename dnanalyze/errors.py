"""The one kind of error that a user causes and can mend."""

import unicodedata

MAX_CHARACTERS = 800  # characters of a message; the longest list of valid names takes 600
# Characters that move a terminal's cursor, turn the direction of text, or are none (what is left
# of a file name that is no UTF-8).
_HIDDEN = {"Cc", "Cs", "Cf"}


def printable(text: str) -> str:
    """The text with "?" for what a terminal does not show as a character."""
    if text.isprintable():
        return text
    return "".join("?" if unicodedata.category(c) in _HIDDEN else c for c in text)


class InputError(ValueError):
    """Bad input: the message is one line that names the file or argument and the remedy.

    What it quotes may come from a hostile file: control characters become "?", and a message that
    is too long loses its middle.

    Parameters
    ----------
    message : object
        What is wrong, and the valid values; its lines become one.
    """

    def __init__(self, message: object = "") -> None:
        text = printable(" ".join(str(message).split()))
        if len(text) > MAX_CHARACTERS:
            text = f"{text[: MAX_CHARACTERS // 2]} ... {text[-MAX_CHARACTERS // 3 :]}"
        super().__init__(text)
