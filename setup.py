"""The long description: README.md with links that work away from the repository.

A package index shows the text without the files beside it. With the address of the repository in
``DNANALYZE_REPOSITORY`` (such as https://host/owner/dnanalyze) relative links lead there; without
it their text stays and the pictures are left out. Everything else is in pyproject.toml.
"""

import os
import re
from pathlib import Path

from setuptools import setup

PICTURE = re.compile(r"!\[[^\]]*\]\((?!https?:)([^)\s]+)\)\n*")
LINK = re.compile(r"\[([^\]]+)\]\((?!https?:|#)([^)\s]+)\)")


def long_description(text: str, repository: str = "") -> str:
    """The text with absolute links."""
    if not repository:
        return LINK.sub(r"\1", PICTURE.sub("", text))
    text = PICTURE.sub(lambda m: m[0].replace(f"({m[1]})", f"({repository}/raw/main/{m[1]})"), text)
    return LINK.sub(rf"[\1]({repository}/blob/main/\2)", text)


if __name__ == "__main__":
    setup(
        long_description=long_description(
            (Path(__file__).parent / "README.md").read_text(encoding="utf-8"),
            os.environ.get("DNANALYZE_REPOSITORY", "").rstrip("/"),
        ),
        long_description_content_type="text/markdown",
    )
