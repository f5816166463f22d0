"""The one kind of error that a user causes and can mend."""


class InputError(ValueError):
    """Bad input: the message is one line that names the file or argument and the remedy."""
