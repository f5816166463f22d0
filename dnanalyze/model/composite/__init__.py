"""An effect composed of words: what changes, when, where, by which law, how it is distributed."""
