"""Streams: a key by name, numbers by place."""

import numpy as np
from scipy.special import ndtr

from dnanalyze.loaders.captures import Window
from dnanalyze.model.streams import Stream

WINDOW = Window(0, 400, 0, 500)


def test_children_differ_by_name_order_and_parent():
    root = Stream.from_seed(1)
    keys = {
        root.key,
        Stream.from_seed(2).key,
        root.child("a").key,
        root.child("b").key,
        root.child("a", "b").key,
        root.child("b", "a").key,
        root.child("a", 1).key,
        root.child("a", 2).key,
        Stream.from_seed(2).child("a").key,
    }
    assert len(keys) == 9
    assert root.child("a").key == Stream.from_seed(1).child("a").key


def test_fields_of_children_are_independent():
    root = Stream.from_seed(5)
    fields = [root.child("frame", n).normal(WINDOW, 500).ravel() for n in range(8)]
    r = np.corrcoef(fields) * np.sqrt(fields[0].size)
    # 28 pairs, standard normal each: 5 sigma
    assert np.abs(r[np.triu_indices(8, 1)]).max() < 5


def test_number_of_a_pixel_depends_on_its_place_alone():
    stream = Stream.from_seed(5).child("x")
    whole = stream.normal(WINDOW, 500)
    part = Window(100, 130, 77, 401)
    np.testing.assert_array_equal(stream.normal(part, 500), whole[part.slices])
    np.testing.assert_array_equal(
        stream.uniform_at(np.array([3, 777])), stream.uniform(WINDOW, 500).ravel()[[3, 777]]
    )


def test_generator_is_repeatable_and_uniform():
    stream = Stream.from_seed(5).child("tracks")
    a, b = stream.generator().random(1000), stream.generator().random(1000)
    np.testing.assert_array_equal(a, b)
    # mean of 1000 uniforms, 5 sigma
    assert abs(a.mean() - 0.5) < 5 / np.sqrt(12 * 1000)


def test_normal_and_uniform_fields_share_their_order():
    stream = Stream.from_seed(8)
    assert np.abs(ndtr(stream.normal(WINDOW, 500)) - stream.uniform(WINDOW, 500)).max() < 1e-6
