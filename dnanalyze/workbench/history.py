"""The history of a session: a tree of models, each with its error and how it was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from dnanalyze.errors import InputError
from dnanalyze.model.noise_model import NoiseModel

MOST_NAME = 80  # characters of a node's name


@dataclass(frozen=True)
class Node:
    """A model at one step of the work.

    Parameters
    ----------
    number : int
        Position in ``History.nodes``.
    parent : int or None
        None: the starting model.
    action : str
        What was done, such as "add column_fpn".
    model : NoiseModel
    command : tuple of str
        Arguments of the command that makes this model from the parent's, such as
        ("add", "column_fpn"); empty where the model was set by hand.
    origin : int or None
        Node whose model the command begins with; the parent by default.
    error : float or None
        Model error (dimensionless); None: not computed yet.
    families : mapping
        Error of each family of statistics.
    exact : bool
        Whether the error is by the yardstick of the model itself.
    name : str
        Given by the user.
    standard_errors : mapping
        Of parameters by name, in plain units; empty: not computed.
    before : float or None
        Of a fit: error of the parent's model by the yardstick of this one; None: not computed.
    """

    number: int
    parent: int | None
    action: str
    model: NoiseModel
    command: tuple[str, ...] = ()
    origin: int | None = None
    error: float | None = None
    families: Mapping[str, float] = field(default_factory=dict)
    exact: bool = False
    name: str = ""
    standard_errors: Mapping[str, float] = field(default_factory=dict)
    before: float | None = None

    @property
    def title(self) -> str:
        """The user's name for it, or what was done."""
        return self.name or self.action


def effects_apart(one: NoiseModel, other: NoiseModel) -> str:
    """Effects that one of two models lacks: ``with column_fpn; without crosstalk``.

    Examples
    --------
    >>> from dnanalyze import NoiseModel
    >>> from dnanalyze.workbench.history import effects_apart
    >>> from dnanalyze.model.effects.column_fpn import ColumnFpn
    >>> effects_apart(NoiseModel(()), NoiseModel(()).with_effect(ColumnFpn()))
    'with column_fpn'
    """
    parts = {
        "with": [n for n in other.names if n not in one.names],
        "without": [n for n in one.names if n not in other.names],
    }
    said = [f"{word} {', '.join(names)}" for word, names in parts.items() if names]
    return "; ".join(said) or "the same effects"


@dataclass(frozen=True)
class History:
    """Every model of a session; nothing is removed from it.

    Parameters
    ----------
    nodes : tuple of Node
    at : int
        Number of the present node.
    undone : tuple of int
        Nodes that a redo visits, the next one last.
    """

    nodes: tuple[Node, ...]
    at: int = 0
    undone: tuple[int, ...] = ()

    @classmethod
    def begun(cls, model: NoiseModel, action: str, command: tuple[str, ...] = ()) -> History:
        """A history of one model."""
        return cls((Node(0, None, action, model, command),))

    @property
    def present(self) -> Node:
        """The node shown."""
        return self.nodes[self.at]

    def node(self, number: int) -> Node:
        """A node by its number.

        Raises
        ------
        InputError
            There is none of that number.
        """
        if not 0 <= number < len(self.nodes):
            raise InputError(f"no node {number} in the history; valid: 0 to {len(self.nodes) - 1}")
        return self.nodes[number]

    def grown(
        self,
        action: str,
        model: NoiseModel,
        command: tuple[str, ...] = (),
        origin: int | None = None,
    ) -> History:
        """A new node below the present one; after an undo it begins a branch."""
        new = Node(len(self.nodes), self.at, action, model, command, origin)
        return History((*self.nodes, new), new.number)

    def revised(self, model: NoiseModel, action: str = "") -> History:
        """The present node with another model, whose error is not known."""
        node = replace(
            self.present,
            model=model,
            action=action or self.present.action,
            error=None,
            families={},
            exact=False,
            standard_errors={},
            before=None,
        )
        return self._changed(node)

    @property
    def open(self) -> bool:
        """Whether the present node has neither children nor a name of the user's."""
        present = self.present
        return not present.name and all(n.parent != present.number for n in self.nodes)

    def undo(self) -> History:
        """The parent of the present node; the same history at the starting model."""
        parent = self.present.parent
        return self if parent is None else History(self.nodes, parent, (*self.undone, self.at))

    def redo(self) -> History:
        """The node that was left by the last undo; the same history where there is none."""
        if not self.undone:
            return self
        return History(self.nodes, self.undone[-1], self.undone[:-1])

    def moved(self, number: int) -> History:
        """Any node as the present one."""
        return History(self.nodes, self.node(number).number)

    def named(self, number: int, name: str) -> History:
        """A node with the user's name."""
        return self._changed(replace(self.node(number), name=name.strip()[:MOST_NAME]))

    def measured(
        self, number: int, error: float, families: Mapping[str, float], exact: bool = True
    ) -> History:
        """A node with its error."""
        node = replace(self.node(number), error=error, families=dict(families), exact=exact)
        return self._changed(node)

    def known(self, number: int, standard_errors: Mapping[str, float]) -> History:
        """A node with the standard errors of its parameters."""
        return self._changed(replace(self.node(number), standard_errors=dict(standard_errors)))

    def beside(self, number: int, before: float) -> History:
        """A node with the error of its parent's model by the node's own yardstick."""
        return self._changed(replace(self.node(number), before=before))

    def path(self, number: int | None = None) -> list[Node]:
        """Nodes from the starting model to one of them; the present one by default."""
        node = self.present if number is None else self.node(number)
        found = [node]
        while node.parent is not None:
            node = self.nodes[node.parent]
            found.append(node)
        return found[::-1]

    def laid_out(self) -> dict[int, tuple[int, int]]:
        """Place of each node in a drawing of the tree: steps from the start, and lane.

        The first child stays in its parent's lane; every further branch has one of its own.

        Examples
        --------
        >>> from dnanalyze import NoiseModel
        >>> from dnanalyze.workbench.history import History
        >>> tree = History.begun(NoiseModel(()), "begun").grown("a", NoiseModel(()))
        >>> tree.moved(0).grown("b", NoiseModel(())).laid_out()
        {0: (0, 0), 1: (1, 0), 2: (1, 1)}
        """
        places: dict[int, tuple[int, int]] = {}
        lanes = 0
        for node in self.nodes:  # parents come before their children
            if node.parent is None:
                places[node.number] = (0, 0)
                continue
            depth, lane = places[node.parent]
            if any(n.parent == node.parent for n in self.nodes[: node.number]):
                lanes += 1
                lane = lanes
            places[node.number] = (depth + 1, lane)
        return places

    def made(self, number: int | None = None) -> list[Node]:
        """Nodes from which commands make a node again, in order.

        The first was set by hand, or is made from the captures alone.
        """
        node = self.present if number is None else self.node(number)
        found = [node]
        while node.command and node.parent is not None:
            node = self.nodes[node.parent if node.origin is None else node.origin]
            found.append(node)
        return found[::-1]

    def _changed(self, node: Node) -> History:
        nodes = (*self.nodes[: node.number], node, *self.nodes[node.number + 1 :])
        return replace(self, nodes=nodes)
