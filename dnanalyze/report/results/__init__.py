"""How each type of result looks, in the file of the type's name.

A file gives ``headline``, ``sections`` (what terminal and page have in common), ``page``,
``document``, ``table`` and ``plots``; see `dnanalyze.report.presentation.Presentation`.
"""
