"""What every result can do: print, tabulate, save, plot and show itself in a notebook.

How a result looks is known to `dnanalyze.report` alone, which is looked up when a method is
called: whoever computes a result imports no figures.
"""

from __future__ import annotations

from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from dnanalyze.report.presentation import Presentation


class Result:
    """The methods that all results share.

    A subclass is a frozen dataclass with a presentation: the file of its name in
    ``dnanalyze.report.results``.
    """

    def summary(self) -> str:
        """Return the text that the command line prints for this result.

        Returns
        -------
        str
            Plain text of at most 80 columns, without colour.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> statistics = dnanalyze.analyze(tiny())
        >>> print(statistics.summary().splitlines()[0])
        virtual sensor: 3 operating points, 25 to 65 °C, 9 frames of 64 × 64
        """
        from dnanalyze.report.presentation import summary

        return summary(self)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON document that the command line writes for this result.

        Returns
        -------
        dict
            Mappings, lists, text and numbers; every number is finite or None.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> statistics = dnanalyze.analyze(tiny())
        >>> statistics.to_dict()["schema"]
        'dnanalyze/analyze/1'
        """
        return self._presentation().document(self)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the numbers of this result as a table.

        Returns
        -------
        pandas.DataFrame
            One row a number; the columns are those of the file that ``--csv`` writes.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> statistics = dnanalyze.analyze(tiny())
        >>> table = statistics.to_dataframe()
        >>> table[table["name"] == "temporal_noise"].shape[0]
        3
        """
        return self._presentation().table(self)

    def save(self, path: str | PathLike[str]) -> None:
        """Write this result to a file, whole or not at all.

        Parameters
        ----------
        path : str or PathLike
            The suffix tells the form: ``.json`` the document, ``.html`` the self-contained report,
            ``.csv`` the table and, of a result with a model, ``.yaml`` the model file.

        Raises
        ------
        InputError
            The suffix is none of these, or the file cannot be written.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> statistics = dnanalyze.analyze(tiny())
        >>> import tempfile, pathlib
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder) / "statistics.csv"
        ...     statistics.save(path)
        ...     path.read_text().startswith("temperature_c")
        True
        """
        from dnanalyze.report.presentation import save

        save(self, self._presentation(), path)

    def plot(self, kind: str | None = None, ax: Axes | None = None) -> Any:
        """Draw this result with matplotlib.

        Parameters
        ----------
        kind : str, optional
            What to draw; by default the most telling figure. An unknown kind is refused with the
            list of those that there are.
        ax : matplotlib.axes.Axes, optional
            Where to draw; by default a new figure. A figure of several panels divides the place of
            this axes among them.

        Returns
        -------
        matplotlib.axes.Axes or numpy.ndarray of Axes
            The axes of the figure; an array where it has several.

        Raises
        ------
        InputError
            There is no such kind, or the captures hold nothing of it.

        Examples
        --------
        >>> import dnanalyze
        >>> from dnanalyze.demo import tiny
        >>> statistics = dnanalyze.analyze(tiny())
        >>> len(statistics.plot("distribution"))
        3
        >>> statistics.plot("pie")
        Traceback (most recent call last):
            ...
        dnanalyze.errors.InputError: kind='pie': unknown; valid: sensor, dark_signal, ...
        """
        from dnanalyze.report.presentation import plot

        return plot(self, self._presentation(), kind, ax)

    def _repr_html_(self) -> str:
        """Verdict, figure and summary for a notebook; self-contained and escaped."""
        from dnanalyze.report.presentation import notebook

        return notebook(self, self._presentation())

    def __repr__(self) -> str:
        """The result in a line."""
        return f"<{type(self).__name__}: {self._brief()}>"

    def _brief(self) -> str:
        """What matters most, in a few words."""
        raise NotImplementedError

    def _presentation(self) -> Presentation:
        """How results of this type look."""
        for kind in type(self).__mro__:
            if Result in kind.__bases__:
                name = kind.__name__.lower()
                return cast("Presentation", import_module(f"dnanalyze.report.results.{name}"))
        raise TypeError(f"{type(self).__name__} has no presentation")
