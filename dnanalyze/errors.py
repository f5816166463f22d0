"""The one kind of error that a user causes and can mend."""

MOST = 800  # characters of a message; the longest list of valid names takes 600


class InputError(ValueError):
    """Bad input: the message is one line that names the file or argument and the remedy.

    What it quotes may come from a hostile file: control characters become "?", and a message that
    is too long loses its middle.
    """

    def __init__(self, message: object = "") -> None:
        text = "".join(c if c.isprintable() else "?" for c in " ".join(str(message).split()))
        if len(text) > MOST:
            text = f"{text[: MOST // 2]} ... {text[-MOST // 3 :]}"
        super().__init__(text)
