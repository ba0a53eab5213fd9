"""``lissom completion``: completion of commands, options and files in a shell."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

#: How each shell takes the script.
INSTALL = {
    "bash": 'eval "$(lissom completion bash)"    # in ~/.bashrc',
    "zsh": 'eval "$(lissom completion zsh)"    # in ~/.zshrc',
    "fish": "lissom completion fish > ~/.config/fish/completions/lissom.fish",
}


@click.command("completion", epilog="\b\n" + "\n".join(INSTALL.values()))
@click.argument("shell", type=click.Choice(list(INSTALL)))
@click.pass_context
def command(context: click.Context, shell: str) -> int:
    """Print the completion script for SHELL.

    It completes commands, options and files.

    Exit code: 0 done, 1 the version of the shell is not supported.
    """
    kind = get_completion_class(shell)
    assert kind is not None, "click knows these shells"
    root = context.find_root()
    try:
        click.echo(kind(root.command, {}, "lissom", "_LISSOM_COMPLETE").source())
    except RuntimeError as error:
        raise click.ClickException(str(error)) from None
    return 0
