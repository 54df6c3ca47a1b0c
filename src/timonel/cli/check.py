"""`timonel check`: what is wrong in a configuration."""

import click

from timonel.gateway.configuration import load


@click.command()
@click.argument("configuration", type=click.Path())
def check(configuration: str) -> None:
    """Tell everything that is wrong in CONFIGURATION (boat.toml, rover.toml), a line each.

    Exits with 2 if there is anything.
    """
    loaded = load(configuration)
    stations, outputs = len(loaded.stations), len(loaded.outputs)
    inputs = f", {len(loaded.inputs)} of instruments" if loaded.inputs else ""
    click.echo(
        f"{configuration}: fine: {stations} {'station' if stations == 1 else 'stations'}, "
        f"{outputs} {'output' if outputs == 1 else 'outputs'}{inputs}, bus {loaded.bus_url}"
    )
