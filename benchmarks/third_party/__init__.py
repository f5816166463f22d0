"""A truth suite of sensors and simulators that share no code with dnanalyze."""
