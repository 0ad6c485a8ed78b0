"""Unknown names: what they could mean."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def suggestion(name: object, known: Iterable[str], most: int = 10) -> str:
    """The end of a message about an unknown name: the nearest known names, or all if they are few."""
    names = list(dict.fromkeys(known))
    lower: dict[str, str] = {}
    for of in names:
        lower.setdefault(of.lower(), of)
    wanted = str(name).lower()
    longer = sorted((of for of in lower if wanted and of.startswith(wanted)), key=len)[:2]
    near = [lower[of] for of in dict.fromkeys([*longer, *difflib.get_close_matches(wanted, lower, 3, 0.6)])][:3]
    near = near or [of for of in names if wanted and wanted in of.lower()][:3]
    if near:
        return f"; did you mean {' or '.join(f'`{of}`' for of in near)}?"
    return f"; known are {', '.join(f'`{of}`' for of in names)}" if 0 < len(names) <= most else ""
