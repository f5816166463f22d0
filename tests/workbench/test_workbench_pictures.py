import numpy as np

from dnanalyze.loaders.captures import Window
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.pictures import Pictures


def test_the_difference_is_that_of_the_means_shown_and_a_model_may_lack(folder, fitted):
    import dnanalyze

    pictures = Pictures(dnanalyze.load(str(folder)))
    view, window = View(setting=1), Window(0, 96, 0, 90)
    found = pictures.picture(view, window, fitted, 48, True)
    assert (found.side, found.measured.shape) == (3, (32, 30))
    np.testing.assert_array_equal(found.difference, found.measured - found.simulated)
    blocks = pictures.whole(view, None)[:, :90].reshape(32, 3, 30, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(found.measured, blocks, rtol=1e-5)
    assert set(found.outliers) == {"measured", "simulated"}
    alone = pictures.picture(view, window, None, 48, False)
    assert np.isnan(alone.simulated).all()
    assert not alone.outliers


def test_images_are_forgotten_beyond_the_memory(folder):
    import dnanalyze

    pictures = Pictures(dnanalyze.load(str(folder)), memory=3 * 4 * 96 * 144)
    for number in range(6):
        pictures.whole(View(setting=number % 2, frame=number // 2), None)
    assert len(pictures._held) == 3


def test_a_pixel_has_a_value_for_every_frame(folder, fitted):
    import dnanalyze

    captures = dnanalyze.load(str(folder))
    found = Pictures(captures).pixel(3, 7, fitted)
    assert [len(x) for x in found["measured"]] == [len(s.frames) for s in captures.settings]
    assert [len(x) for x in found["simulated"]] == [len(s.frames) for s in captures.settings]
    assert found["measured"][1][2] == captures.settings[1].frames[2].read()[3, 7]
