"""The workbench's page: a thin view of a session, in Panel and Bokeh."""
