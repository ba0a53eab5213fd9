"""Numbers in words of reports, written as the player writes them beside curves: 1.2·10⁻⁵, −0.3."""

from __future__ import annotations

import re

#: Numbers that belong to code, such as rtol=1e-6, remain as they are typed.
_NUMBER = re.compile(r"(?<![\w.=`])(-?)(\d+(?:\.\d+)?)(?:e([+-]?\d+))?(?![\w`])")

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def typeset(text: str) -> str:
    """The text with powers of ten and signs of its numbers as in print.

    Examples
    --------
    >>> from lissom.drawing.report.numerals import typeset
    >>> typeset("from -3.5e-05 to 2 m, with rtol=1e-6")
    'from −3.5·10⁻⁵ to 2 m, with rtol=1e-6'
    """
    return _NUMBER.sub(_printed, text)


def _printed(found: re.Match[str]) -> str:
    sign, factor, exponent = found.groups()
    power = "" if exponent is None else f"·10{str(int(exponent)).translate(_RAISED)}"
    return ("−" if sign else "") + factor + power
