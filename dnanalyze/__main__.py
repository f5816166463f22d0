"""``python -m dnanalyze``: the command line."""

from dnanalyze_cli.main import run

if __name__ == "__main__":
    run()
