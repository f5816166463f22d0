import pytest

from dnanalyze.errors import InputError
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.history import History


def _models(n):
    return [NoiseModel((), pedestal=float(i)) for i in range(n)]


def test_undo_and_redo_visit_the_same_nodes_in_turn():
    a, b, c = _models(3)
    history = History.begun(a, "start").grown("one", b).grown("two", c)
    back = history.undo().undo()
    assert back.present.model == a
    assert back.undo() == back
    assert [n.action for n in back.redo().redo().path()] == ["start", "one", "two"]
    assert history.redo() == history


def test_work_after_an_undo_is_a_branch_and_nothing_is_lost():
    a, b, c = _models(3)
    history = History.begun(a, "start").grown("one", b).undo().grown("other", c)
    assert [n.model for n in history.nodes] == [a, b, c]
    assert history.present.parent == 0
    assert not history.undone
    assert history.moved(1).present.model == b


def test_a_name_is_kept_and_bounded():
    history = History.begun(_models(1)[0], "start").named(0, "  before firmware 2 " + "x" * 200)
    assert history.present.title.startswith("before firmware 2")
    assert len(history.present.title) == 80


def test_an_unknown_node_is_refused():
    with pytest.raises(InputError, match="no node 7 in the history; valid: 0 to 0"):
        History.begun(_models(1)[0], "start").moved(7)


def test_commands_begin_at_the_last_model_set_by_hand():
    a, b, c, d, e = _models(5)
    history = (
        History.begun(a, "guess")
        .grown("fit", b, ("fit",))
        .grown("set", c)
        .grown("step", d)
        .grown("refine", e, ("refine",), origin=2)
    )
    assert [n.action for n in history.made()] == ["set", "refine"]
    assert [n.action for n in history.made(1)] == ["guess", "fit"]
    assert [n.action for n in history.made(3)] == ["step"]


def test_a_revised_node_keeps_its_place_and_forgets_its_error():
    before, first, second = _models(3)
    history = History.begun(before, "begun").grown("set a", first).measured(1, 2.0, {"x": 1.0})
    assert history.open
    changed = history.revised(second)
    assert (changed.present.model, changed.present.error, len(changed.nodes)) == (second, None, 2)
    assert changed.undo().present.model == before
    assert not history.named(1, "kept").open
    assert not history.undo().open


def test_branches_of_the_drawn_tree_never_share_a_place():
    tree = History.begun(NoiseModel(()), "begun")
    for parent in (0, 1, 1, 0, 3, 2):
        tree = tree.moved(parent).grown("step", NoiseModel(()))
    places = tree.laid_out()
    assert len(set(places.values())) == len(tree.nodes)
    for node in tree.nodes[1:]:
        assert places[node.number][0] == places[node.parent][0] + 1
